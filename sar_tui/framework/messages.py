"""Every message of the loop. Frozen; times are ns of the session's clock unless the name says otherwise.

Messages hold no session id and no participant code: two sessions with the same seed and the same presses
hold the same messages.
"""

from typing import Literal

import msgspec

from sar_tui.framework.theme import Theme

Valence = Literal["positive", "neutral", "negative"]
Degree = Literal["slight", "clear", "strong"]
Schedule = Literal["every", "faded", "bandwidth", "summary", "request", "none"]
Form = Literal["qualitative", "quantitative", "both"]
Reference = Literal["last attempt", "best attempt", "session's mean", "goal"]
Kind = Literal["greeting", "instruction", "encouragement", "feedback", "rest", "goodbye"]
Policy = Literal["queue", "interrupt", "drop"]
Deed = Literal["say", "show", "gesture", "gaze", "tone"]
DeedState = Literal["queued", "started", "done", "aborted", "failed"]
Outcome = Literal["success", "failure"]
Json = dict[str, str | int | float | bool | None]
"""What a task may add to a trial's row."""
SensorState = Literal["attached", "detached", "error", "gap", "saturated", "stalled", "flowing", "ended"]


class Message(msgspec.Struct, frozen=True, kw_only=True):
    """The base of all messages. ``seat`` is who caused it, or whom it concerns."""

    seat: str = "A"


# --- inputs: what comes from outside the nodes -----------------------------------------------------------


class SessionStarted(Message, frozen=True, kw_only=True):
    """A run of the program begins on a session. ``run`` counts from 1; above 1 the session is resumed.

    ``best``: the participant's best results of earlier sessions, by level (as text).
    """

    run: int
    task: str
    theme: str
    seed: int
    best: dict[str, float] = {}


class ThemeWorn(Message, frozen=True, kw_only=True):
    """What the agent looks like and how it speaks, from here on: at the beginning of a run, and after each edit."""

    theme: Theme


class KeyPressed(Message, frozen=True, kw_only=True):
    """A key, stamped in the input thread. ``key`` is the character it types, or its name (``enter``, ``left``).

    ``loop_lag``: how late (ns) the event loop was at its worst since the last prompt or key.
    """

    key: str
    at: int
    loop_lag: int = 0


class Pasted(Message, frozen=True, kw_only=True):
    """Text was pasted: never a response. Only its length is kept."""

    length: int
    at: int


class FocusChanged(Message, frozen=True, kw_only=True):
    """The terminal's window gained or lost the keyboard focus."""

    focused: bool
    at: int


class Shown(Message, frozen=True, kw_only=True):
    """A prompt reached the terminal.

    ``source``: ``flush`` (stamped as the frame was flushed), ``refresh`` (after Textual's refresh: less sure),
    ``virtual`` (simulated).
    """

    attempt: int
    trial: int
    presentation: int
    at: int
    source: Literal["flush", "refresh", "virtual"]


class ImuBlock(Message, frozen=True, kw_only=True):
    """Samples of a motion sensor, in the order in which they were taken; many a second, so they are a stream.

    ``samples``: as `motion.samples.pack` lays them out.
    """

    samples: bytes


class SensorChanged(Message, frozen=True, kw_only=True):
    """Something happened to the motion sensor at ``at`` (see `inputs.imu.Status`).

    ``count`` and ``duration_ms`` tell of missing samples. What the sensor is (``model``, ``serial``, ``rate_hz``,
    the largest it can measure) is told when it is ``attached``.
    """

    state: SensorState
    at: int
    detail: str = ""
    count: int = 0
    duration_ms: float = 0.0
    source: str = ""
    model: str = ""
    serial: str = ""
    rate_hz: float = 0.0
    rate_range_rad_s: float = 0.0
    acceleration_range_m_s2: float = 0.0


class TimerFired(Message, frozen=True, kw_only=True):
    """A node's timer fired. ``token`` tells it from an earlier timer of the same name."""

    node: str
    name: str
    token: int
    due: int


class Operator(Message, frozen=True, kw_only=True):
    """An act that steers the session.

    ``command``: ``pause``, ``resume``, ``end``, ``skip`` (this prompt), ``repeat`` (this prompt), ``level``
    (``value``), ``mark`` (the trial under way, else the last), ``stop`` (everything the agent says and does; ``at`` is
    the key's stamp). ``reason``: for a pause, how the person is: ``tired``,
    ``pain``, ``finished``, or empty; for a mark, which (see `task.Mark`).
    """

    command: Literal["pause", "resume", "end", "skip", "repeat", "level", "mark", "stop"]
    actor: str = "participant"
    reason: str = ""
    value: int | None = None
    at: int = 0


class OutputReport(Message, frozen=True, kw_only=True):
    """An output tells what became of a part of an action. ``detail`` says why it failed.

    ``queued``: the output has taken it on; ``started``: it can be heard or seen; then ``done``, ``aborted`` (stopped
    before its end) or ``failed``.
    """

    action: str
    output: str
    deed: Deed
    state: DeedState
    at: int
    detail: str = ""


class OutputStopped(Message, frozen=True, kw_only=True):
    """An output that was told to stop at ``asked`` is still since ``at``. ``detail`` says why, where it is not."""

    output: str
    asked: int
    at: int
    detail: str = ""


class Stored(Message, frozen=True, kw_only=True):
    """The trial, and everything before it, is on disk."""

    attempt: int
    trial: int


class StorageChanged(Message, frozen=True, kw_only=True):
    """The disk refuses to write (``working`` False), or writes again."""

    working: bool
    reason: str = ""


# --- derived: what the nodes conclude ---------------------------------------------------------------------


class Percept(Message, frozen=True, kw_only=True):
    """What a person did, as a task sees it. ``at``: when; ``delay``: from then to its handling, in ns.

    ``repeat``: the same key again within the repeat interval (a held key, a bouncing contact): never a response.
    """

    at: int
    delay: int = 0
    loop_lag: int = 0
    repeat: bool = False


class KeyPerceived(Percept, frozen=True, kw_only=True):
    """A key. ``gap`` is the time since the key before, None for the first."""

    key: str
    gap: int | None = None


class ReachPerceived(Percept, frozen=True, kw_only=True):
    """A reach, out and back, as a motion sensor saw it; without ``onset`` there was none to be seen.

    ``onset``, ``turn``, ``end`` in ns. ``closed``: what told that it was over: ``key``, ``stillness``, ``timeout``.
    ``details``: what was measured of it. ``flags``: what to beware of. ``invalid``: why nothing can be said of it,
    so that it has to be done again; empty where something can. ``trace``: how fast the hand turned about the reach's
    axis, rad/s, out is positive, ``trace_hz`` values a second: to be drawn, not to be analysed. ``trace_marks``: where
    in it, in s, the hand left, arrived at the target, left that, and was back.
    """

    onset: int | None = None
    turn: int | None = None
    end: int | None = None
    closed: Literal["key", "stillness", "timeout"]
    details: Json = {}
    flags: tuple[str, ...] = ()
    invalid: str = ""
    trace: tuple[float, ...] = ()
    trace_hz: float = 0.0
    trace_marks: tuple[float, float, float, float] | None = None


class Waiting(Message, frozen=True, kw_only=True):
    """What the session waits for, so that a screen can say so and a simulated participant can answer.

    ``what``: ``enter`` (Return), ``start`` (the key with which the participant starts a trial), ``agent`` (until it
    has spoken and is still), ``answer`` (until feedback is given, which comes after a delay), ``quiet`` (no keys for a
    moment), ``foreperiod``, ``storage`` (the disk), ``response``, ``resume`` (paused), ``sensor`` (it has come loose),
    ``nothing`` (ended). ``stage`` says where: ``instructions``, ``attempt``,
    ``trial``, ``answer``, ``paused``, ``review`` (all attempts are done), ``ended``, ``broken`` (something failed).
    ``attempt_name`` is the attempt in words, "attempt 3 of 20"; ``goal`` what it aims at, but for trials.
    ``notice`` is what the participant has to know first: another level, a trial that has to be done again.
    ``reason``, when paused: how the person is (see `Operator`), ``interrupted`` (the program had ended),
    ``storage`` (the disk refuses; also at the end), ``restored`` (it no longer does), ``sensor`` (nothing comes from
    it); when quiet is awaited: ``held`` (keys are pressed all the time). ``detail`` is for the experimenter: the
    disk's or the sensor's own words. ``ask``: the key that asks for feedback on the last attempt, where there is some
    to be had.
    """

    what: Literal[
        "enter",
        "start",
        "agent",
        "answer",
        "quiet",
        "foreperiod",
        "storage",
        "response",
        "resume",
        "sensor",
        "nothing",
    ]
    stage: Literal["instructions", "attempt", "trial", "answer", "paused", "review", "ended", "broken"]
    attempt: int = 0
    trial: int = 0
    level: int = 0
    attempt_name: str = ""
    trials: int = 0
    goal: str = ""
    notice: str = ""
    reason: str = ""
    detail: str = ""
    ask: str = ""


class AttemptStarted(Message, frozen=True, kw_only=True):
    """The participant began an attempt."""

    attempt: int
    practice: bool
    level: int
    trials: int


class Prompt(Message, frozen=True, kw_only=True):
    """Show this now. ``text`` is its plain line, ``glyph`` what to draw very large, ``hint`` a word of help.

    ``expected`` is the key that answers it (empty where any will do); ``presentation`` counts how often this
    trial was shown (a pause repeats it); ``timeout`` is how long a response is awaited, in ns; ``started`` when the
    participant started the trial, None where trials come by themselves.
    """

    attempt: int
    trial: int
    presentation: int
    level: int
    stimulus: str
    expected: str
    text: str
    glyph: str
    hint: str = ""
    choices: int
    timeout: int
    started: int | None = None


class PromptVoided(Message, frozen=True, kw_only=True):
    """A prompt, or the wait before it, was broken off; the trial will be repeated. It leaves no row."""

    attempt: int
    trial: int
    presentation: int
    reason: str


class Timing(msgspec.Struct, frozen=True):
    """The timing quality of one trial, so that a bad one can be excluded rather than averaged in.

    ``handler_delay_ms``: from the key's stamp to its handling. ``loop_lag_ms``: how late the loop was at its
    worst while the response was awaited. ``false_starts``: keys pressed in the foreperiod, which began it anew.
    ``flags``: ``anticipation``, ``focus_lost``, ``paste``, ``repeat_key``, ``late_key``, ``skipped``,
    ``onset_refresh``.
    """

    onset_source: str
    handler_delay_ms: float | None
    loop_lag_ms: float
    false_starts: int
    presentation: int
    foreperiod_ms: float
    flags: tuple[str, ...]


class TrialEnded(Message, frozen=True, kw_only=True):
    """One prompt and what came of it. A miss has no response. ``value`` is what it adds to the metric.

    ``onset`` is the prompt's, or that of the movement where a task times movements; ``response_at`` then is its end.
    """

    attempt: int
    trial: int
    stimulus: str
    response: str | None
    correct: bool
    onset: int | None
    response_at: int | None
    reaction_time_ms: float | None
    value: float | None
    timing: Timing
    details: Json


class TrialMarked(Message, frozen=True, kw_only=True):
    """A therapist marked a trial: ``mark`` by its name (empty: taken back), and whether it can be correct so."""

    attempt: int
    trial: int
    mark: str
    correct: bool


class FeedbackChoice(msgspec.Struct, frozen=True):
    """Whether an attempt is answered, and why; and if so, how (see `policies.feedback.choose`).

    ``why`` is one plain sentence. ``since``: how many scored attempts there were since the last answer, this one
    included. ``interval``: after how many an answer is due, where the schedule counts them. ``tolerance``: how far from
    the goal is still within the bandwidth, in the metric's unit. ``attempts``: how many attempts the answer sums up.
    """

    schedule: Schedule
    due: bool
    why: str
    content: Literal["results", "performance", "both"]
    form: Form
    compared_with: Reference
    degree: Degree
    delay_ms: int = 0
    since: int = 1
    interval: int | None = None
    tolerance: float | None = None
    attempts: int = 1


class AttemptEnded(Message, frozen=True, kw_only=True):
    """One attempt, scored. ``feedback`` is ``none`` where none was due; ``choice`` says why, and how it is given.

    ``goal`` is what the metric was held against; ``qualities`` are the means of the task's qualities (knowledge of
    performance), by name.
    """

    attempt: int
    practice: bool
    level: int
    metric: float | None
    metric_unit: str
    accuracy: float | None
    correct: int
    trials: int
    goal: float | None = None
    outcome: Outcome
    feedback: Literal["positive", "neutral", "negative", "none"]
    qualities: dict[str, float] = {}
    choice: FeedbackChoice | None = None
    started: int
    ended: int


class LevelChanged(Message, frozen=True, kw_only=True):
    """The difficulty for the next attempt. ``reason``: ``success``, ``failure``, ``operator``, ``mark`` (of one)."""

    previous: int
    level: int
    reason: str


class Feedback(Message, frozen=True, kw_only=True):
    """The agent owes the participant an answer to an attempt.

    ``reason``: ``goal`` (reached), ``missed``, ``band`` (about the goal), ``accuracy`` (too low), ``empty``
    (no response could be timed); ``remark``: what the task has to say of the last two. ``reached``: how many
    attempts reached their goal, of those it sums up; then ``metric`` and ``goal`` are means. ``due``: when it is to be
    given (ns); ``choice``: how, and why.
    """

    attempt: int
    level: int
    valence: Valence
    reason: Literal["goal", "missed", "band", "accuracy", "empty"]
    metric: float | None
    goal: float
    accuracy: float | None
    correct: int
    trials: int
    reached: int
    qualities: dict[str, float] = {}
    remark: str = ""
    due: int = 0
    choice: FeedbackChoice


class Saying(Message, frozen=True, kw_only=True):
    """What the agent says and does at once. ``text`` is shown, ``spoken`` said; where one is empty it is left out.

    ``face``, ``gesture``, ``gaze`` and ``tone`` are the theme's; empty where there is none. ``joins``: it adds to what
    stands on the screen instead of taking its place. ``priority``: the higher comes first. ``policy``: ``queue`` (waits
    its turn), ``interrupt`` (what is under way, if that is no more important), ``drop`` (if its turn does not come
    before the session goes on). ``due``: not before this time (ns).
    """

    id: str
    kind: Kind
    text: str
    spoken: str = ""
    face: str = ""
    gesture: str = ""
    gaze: str = ""
    tone: str = ""
    valence: Valence | None = None
    degree: Degree | None = None
    attempt: int = 0
    joins: bool = False
    priority: int = 0
    policy: Policy = "queue"
    due: int = 0


class Proposal(Saying, frozen=True, kw_only=True):
    """What the agent would say."""


class Action(Saying, frozen=True, kw_only=True):
    """What is said, and who decided it."""

    decision: Literal["accepted", "edited", "rejected"]
    actor: str


class Dropped(Message, frozen=True, kw_only=True):
    """A proposal came to nothing: ``late`` (the session had gone on), ``stopped`` (by the stop key), ``amended`` (the
    attempt was scored anew before its answer was given).
    """

    id: str
    reason: Literal["late", "stopped", "amended"]


class Halt(Message, frozen=True, kw_only=True):
    """Outputs: be still. ``action``: which (empty: all); ``asked``: since when (ns)."""

    action: str = ""
    reason: Literal["stopped", "interrupted", "left"]
    asked: int


class OutputOpened(Message, frozen=True, kw_only=True):
    """An output is there for this run, and what it can do; ``address`` is how it was asked for."""

    output: str
    address: str
    can: tuple[Deed, ...]


class AgentActing(Message, frozen=True, kw_only=True):
    """Whether the agent speaks or moves, so that no prompt is shown meanwhile."""

    acting: bool


class SessionEnded(Message, frozen=True, kw_only=True):
    """The session is over: ``completed`` (every attempt done) or ``aborted`` (ended by a person)."""

    status: Literal["completed", "aborted"]


class Fault(Message, frozen=True, kw_only=True):
    """A handler raised, at ``place``. The session's log keeps the trace; a participant never sees it."""

    node: str
    topic: str
    error: str
    place: str = ""
    trace: str


# --- services ------------------------------------------------------------------------------------------------


class Recall(Message, frozen=True, kw_only=True):
    """Ask for the scored attempts so far, oldest first; ``level`` restricts, practice is left out."""

    level: int | None = None


class Attempts(Message, frozen=True, kw_only=True):
    """The answer to Recall. ``earlier_best``: the best of earlier sessions at that level, if one was asked for."""

    attempts: tuple[AttemptEnded, ...]
    earlier_best: float | None = None

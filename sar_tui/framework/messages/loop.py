"""What perception and the event handler conclude: percepts, waits, prompts, trials, attempts."""

from typing import Literal

import msgspec

from sar_tui.framework.messages.base import Degree, Form, Json, Message, Outcome, Reference, Valence

__all__ = [
    "AttemptEnded",
    "AttemptStarted",
    "CueGiven",
    "Fault",
    "Feedback",
    "FeedbackChoice",
    "KeyPerceived",
    "LevelChanged",
    "LevelReply",
    "LevelRequest",
    "Percept",
    "Prompt",
    "PromptVoided",
    "ReachPerceived",
    "Recall",
    "RecalledAttempts",
    "SessionEnded",
    "Timing",
    "TrialEnded",
    "TrialMarked",
    "Waiting",
]


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
    ``seat``: whose turn it is, or whose ``sensor`` is waited for; empty: everybody's, or not known before the prompt.
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
    participant started the trial, None where trials come by themselves. ``seat``: whose it is; empty: everybody's.
    ``halves``: what stands in the left and in the right half of the screen, in place of the glyph. ``cue``: to which
    side the agent looked or pointed before.
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
    halves: tuple[str, ...] = ()
    cue: str = ""


class CueGiven(Message, frozen=True, kw_only=True):
    """Shortly before a prompt the agent looks or points to a side: outputs do it now, out of any turn.

    ``gaze`` (one of `theme.GAZES`) and ``gesture`` are empty where there is none.
    """

    attempt: int
    trial: int
    presentation: int
    side: Literal["left", "right"]
    gaze: str = ""
    gesture: str = ""

    @property
    def id(self) -> str:
        """What outputs call it in their reports."""
        return f"cue-{self.attempt}-{self.trial}-{self.presentation}"


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
    ``flags``: ``anticipation``, ``focus_lost``, ``paste``, ``repeat_key``, ``late_key``, ``other_seat`` (a key of
    somebody whose turn it was not), ``skipped``, ``onset_refresh``.
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

    schedule: str
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
    (no response could be timed); ``remark``: what the task has to say of the last two. Of a race: ``won``, ``lost``,
    ``drawn``, and how many trials of it were ``won``. ``reached``: how many attempts reached their goal, of those it
    sums up; then ``metric`` and ``goal`` are means. ``due``: when it is to be given (ns); ``choice``: how, and why.
    """

    attempt: int
    level: int
    valence: Valence
    reason: Literal["goal", "missed", "band", "accuracy", "empty", "won", "lost", "drawn"]
    metric: float | None
    goal: float
    accuracy: float | None
    correct: int
    trials: int
    reached: int
    won: int | None = None
    qualities: dict[str, float] = {}
    remark: str = ""
    due: int = 0
    choice: FeedbackChoice


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


class LevelRequest(Message, frozen=True, kw_only=True):
    """May the level change? ``is_last``: after the last attempt, where nobody is asked any more: it does, or stays."""

    change: LevelChanged
    is_last: bool


class LevelReply(Message, frozen=True, kw_only=True):
    """The answer to a change of level: whether it happens now, or waits for an operator, or does not happen."""

    happens: bool


class Recall(Message, frozen=True, kw_only=True):
    """Ask for the scored attempts so far, oldest first; ``level`` restricts, practice is left out."""

    level: int | None = None


class RecalledAttempts(Message, frozen=True, kw_only=True):
    """The answer to Recall. ``earlier_best``: the best of earlier sessions at that level, if one was asked for."""

    attempts: tuple[AttemptEnded, ...]
    earlier_best: float | None = None

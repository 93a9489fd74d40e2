"""Messages of perception and the event handler: percepts, waits, prompts, trials, attempts."""

from typing import Any, Literal

import msgspec

from sar_tui.model.frames import Frame
from sar_tui.model.messages.base import Degree, Form, Json, Message, Outcome, Reference, Valence
from sar_tui.model.step import Answer, Entry, Step
from sar_tui.model.step import Kind as StepKind
from sar_tui.model.tone import Tone
from sar_tui.model.trial_types import UNSURE

__all__ = [
    "AskedStep",
    "AttemptEnded",
    "AttemptStarted",
    "CueGiven",
    "EndStatus",
    "Fault",
    "Feedback",
    "FeedbackChoice",
    "FrameDue",
    "GoalChanged",
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
    "Spread",
    "StepEnded",
    "StepStatus",
    "TakenBack",
    "TakenBackKind",
    "TextPerceived",
    "Timing",
    "ToneDue",
    "TonesAhead",
    "TrialEnded",
    "TrialFeedback",
    "TrialMarked",
    "Typed",
    "Waiting",
]


class Percept(Message, frozen=True, kw_only=True):
    """Something a participant did, as a task sees it. ``delay``: from ``at`` until it was handled,
    in ns.

    ``repeat``: the same key again within the repeat interval (a held key, a bouncing contact):
    never a response. ``stalled``: the program had just been suspended, so that it was done at some
    unknown time before ``at``.
    """

    at: int
    delay: int = 0
    loop_lag: int = 0
    repeat: bool = False
    stalled: bool = False


class KeyPerceived(Percept, frozen=True, kw_only=True):
    """A key. ``gap``: time since the previous key, None for the first."""

    key: str
    gap: int | None = None


class TextPerceived(Percept, frozen=True, kw_only=True):
    """A text that was typed and sent with Enter, ``at`` that time.

    ``began``: time stamp (ns) of its first key; None if Enter was the only one. ``keys``: number of
    keys that changed it; ``corrections``: of those, how many deleted a character.
    """

    text: str
    began: int | None = None
    keys: int = 0
    corrections: int = 0


class ReachPerceived(Percept, frozen=True, kw_only=True):
    """A reach, out and back, as measured by a motion sensor; without ``onset`` no movement was
    found.

    ``onset``, ``turn``, ``end``: in ns. ``closed``: what ended the recording: ``key``,
    ``stillness``, ``timeout``. ``details``: the measures. ``flags``: warnings. ``invalid``: why the
    reach cannot be measured and must be repeated; else empty. ``trace``: angular velocity about the
    reach's axis in rad/s, positive outwards, ``trace_hz`` values per second, for display only.
    ``trace_marks``: times in it (s) at which the hand left, reached the target, left the target,
    and was back.
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


class AskedStep(msgspec.Struct, frozen=True, omit_defaults=True, kw_only=True):
    """A step that stands on the screen.

    ``number`` counts the steps of the session from 1. ``step``: with its texts in the session's
    language. ``seat``: who is asked; ``who``: their name, if there are several. ``shown``: since
    when (ns). ``entry``: what they have chosen or typed.
    """

    number: int
    step: Step
    seat: str = "A"
    who: str = ""
    shown: int = 0
    entry: Entry = Entry()


class Waiting(Message, frozen=True, kw_only=True):
    """The session waits. A screen shows this; a simulated participant reacts to it.

    ``what``: ``enter`` (the Return key), ``start`` (the key that starts a trial), ``agent`` (until
    it is still), ``answer`` (until delayed feedback is given), ``step`` (for an answer, or until it
    is over), ``rest`` (until a rest is over), ``quiet`` (no keys for a moment), ``foreperiod``,
    ``storage`` (the disk), ``response``, ``result`` (the answer to a trial is shown), ``resume``
    (paused), ``sensor`` (no data), ``nothing`` (ended). ``stage``: ``instructions``, ``attempt``
    (before one), ``trial``, ``answer``, ``step``, ``rest``, ``paused``, ``review`` (all attempts
    are done), ``ended``, ``broken`` (something failed). ``attempt_name``: for people, "attempt 3 of
    20". ``goal``: of the attempt; empty in trials. ``seat``: whose turn it is, or whose sensor is
    awaited; empty for everybody's, or if it is unknown before the prompt. ``notice``: shown to the
    participant first: a new level, a trial to repeat, a limit. ``why``: why level or goal have
    changed, or the last attempt does not count, for the participant. ``reason``, in a pause: how
    the participant is (see `SessionCommand`), ``interrupted`` (the program had ended), ``storage``
    (writing fails; also at the end), ``restored`` (writing works again), ``sensor`` (no data),
    ``visit`` (the participant is asked whether somebody may watch, see `VisitRequested`);
    while it waits for quiet: ``held`` (a key is held down). ``detail``: the error of disk or
    sensor, for the experimenter. ``ask``: the key that requests feedback on the last attempt, if
    there is some. ``until``: when a rest is over, or the attempt begins by itself (ns).
    ``restarts``: number of attempts so far that were interrupted and began again under the next
    number. ``step``: the question, or another step, that stands on the screen.
    """

    what: Literal[
        "enter",
        "start",
        "agent",
        "answer",
        "step",
        "rest",
        "quiet",
        "foreperiod",
        "storage",
        "response",
        "result",
        "resume",
        "sensor",
        "nothing",
    ]
    stage: Literal[
        "instructions",
        "attempt",
        "trial",
        "answer",
        "step",
        "rest",
        "paused",
        "review",
        "ended",
        "broken",
    ]
    attempt: int = 0
    trial: int = 0
    level: int = 0
    attempt_name: str = ""
    trials: int = 0
    goal: str = ""
    notice: str = ""
    why: str = ""
    reason: str = ""
    detail: str = ""
    ask: str = ""
    until: int = 0
    restarts: int = 0
    step: AskedStep | None = None


class AttemptStarted(Message, frozen=True, kw_only=True):
    """The participant began an attempt. ``condition``: see `Task.condition`."""

    attempt: int
    practice: bool
    level: int
    trials: int
    condition: str = ""


class Prompt(Message, frozen=True, kw_only=True):
    """A prompt to show now. ``text``: the plain line; ``glyph``: drawn very large; ``hint``: short
    help.

    ``expected``: the correct key (empty for any). ``presentation``: how often this trial has been
    shown, since a pause repeats it. ``timeout``: for the response, in ns. ``started``: when the
    participant started the trial, None if trials start by themselves. ``seat``: the seat it is for;
    empty for all. ``halves``: texts for the left and right half of the screen, instead of the
    glyph. ``cue``: the side to which the agent looked or pointed before. ``frames``: shown one
    after the other, from the first; ``text`` then only says what the prompt is. ``colour``: the
    name of the glyph's colour, empty for that of texts. ``picture``: a file in the task's folder,
    shown instead of the glyph. ``tone``: sounds with it. ``data``: what the task keeps with the
    trial, never shown. ``expects``: what answers it: a ``key``, or typed ``text`` or ``digits``.
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
    frames: tuple[Frame, ...] = ()
    colour: str = ""
    picture: str = ""
    tone: Tone | None = None
    data: dict[str, Any] = {}
    expects: str = "key"

    def shown(self, frame: int = 0, typed: str = "") -> "Prompt":
        """Return the prompt with the contents of a frame, to be drawn; ``typed`` stands in place of
        its hint.
        """
        prompt = self._framed(frame) if self.frames else self
        if self.expects == "key" or frame < len(self.frames) - 1:
            return prompt
        return msgspec.structs.replace(prompt, hint=f"{typed}_")

    def _framed(self, frame: int) -> "Prompt":
        now = self.frames[frame]
        return msgspec.structs.replace(
            self,
            text=now.line,
            glyph=now.glyph,
            hint=now.hint,
            halves=now.halves,
            colour=now.colour,
            picture=now.picture,
        )


class Typed(Message, frozen=True, kw_only=True):
    """The text that the participant has typed so far, to be shown; empty after it was sent."""

    attempt: int
    trial: int
    presentation: int
    text: str


class FrameDue(Message, frozen=True, kw_only=True):
    """A later frame of a prompt is to be drawn now, and to be seen ``at`` a time (ns).

    ``frame``: its place, from 1: the first comes with the prompt.
    """

    attempt: int
    trial: int
    presentation: int
    frame: int
    at: int


class TonesAhead(Message, frozen=True, kw_only=True):
    """The tones of the next prompt, so that they can be prepared before it is shown."""

    tones: tuple[Tone, ...]


class ToneDue(Message, frozen=True, kw_only=True):
    """A tone of a prompt is to sound from ``at`` (ns) on, or as soon after it as it can. ``frame``:
    that it belongs to.

    What of it has not sounded when the trial ends is dropped.
    """

    attempt: int
    trial: int
    presentation: int
    frame: int
    tone: Tone
    at: int


class CueGiven(Message, frozen=True, kw_only=True):
    """The agent looks or points to a side shortly before a prompt. Outputs do it at once, outside
    the action queue.

    ``gaze`` (one of `theme.GAZES`) and ``gesture`` may be empty.
    """

    attempt: int
    trial: int
    presentation: int
    side: Literal["left", "right"]
    gaze: str = ""
    gesture: str = ""

    @property
    def id(self) -> str:
        """Id of the cue in the reports of outputs."""
        return f"cue-{self.attempt}-{self.trial}-{self.presentation}"


class PromptVoided(Message, frozen=True, kw_only=True):
    """A prompt, or the wait before it, was cancelled. The trial is repeated; the cancelled one has
    no row.
    """

    attempt: int
    trial: int
    presentation: int
    reason: str


class Timing(msgspec.Struct, frozen=True, omit_defaults=True):
    """Timing quality of one trial, so that a bad trial can be excluded from analysis.

    ``handler_delay_ms``: from the key's time stamp until it was handled. ``loop_lag_ms``: largest
    delay of the event loop while the response was awaited. ``false_starts``: keys pressed in the
    foreperiod, each of which restarted it. ``flags``: ``anticipation``, ``focus_lost``, ``paste``,
    ``unreadable_input``, ``repeat_key``, ``late_key``, ``other_seat`` (a key of a participant whose
    turn it was not), ``skipped``, ``onset_refresh``, ``early_key`` (a key before the frame from
    which responses are awaited), ``no_picture`` (its glyph was drawn instead), ``tone_failed``,
    ``late_frame`` (one was seen over 10 ms after its time), ``unsure`` (see `trial_types.UNSURE`).
    ``frame_onsets_ns``: onsets of the frames that were shown; ``tone_onsets_ns``: of the tones that
    began, by ``tone_source`` (see `ToneBegan`).
    """

    onset_source: str
    handler_delay_ms: float | None
    loop_lag_ms: float
    false_starts: int
    presentation: int
    foreperiod_ms: float
    flags: tuple[str, ...]
    frame_onsets_ns: tuple[int, ...] = ()
    tone_onsets_ns: tuple[int, ...] = ()
    tone_source: str = ""


class TrialEnded(Message, frozen=True, kw_only=True):
    """One prompt and its result. A miss has no response. ``value``: its contribution to the metric.

    ``onset``: of the prompt; in tasks that time movements, of the movement, with ``response_at`` as
    its end. ``data``: of the prompt.
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
    data: dict[str, Any] = {}

    @property
    def is_unsure(self) -> bool:
        """True if it is not scored, as it may not have been a response, and no mark says what it
        was.
        """
        return UNSURE in self.timing.flags and not self.details.get("mark")


class TrialFeedback(Message, frozen=True, kw_only=True):
    """An answer to a trial, to be shown now: quiet, and before the next trial begins.

    ``seat``: of the participant it is for; empty for all. ``halves``: texts for the left and right
    half of the screen, if the seats get different ones. ``duration``: from when it reached the
    terminal, in ns.
    """

    attempt: int
    trial: int
    text: str
    halves: tuple[str, ...] = ()
    duration: int


class TrialMarked(Message, frozen=True, kw_only=True):
    """A therapist marked a trial. ``mark``: its name, empty if it was removed; ``correct``: with
    the mark.
    """

    attempt: int
    trial: int
    mark: str
    correct: bool


class FeedbackChoice(msgspec.Struct, frozen=True):
    """Decision on feedback for an attempt: due or not, why, and the form (see
    `policies.feedback_choice.choose`).

    ``why``: one plain sentence. ``since``: scored attempts since the last feedback, this one
    included. ``interval``: the number after which feedback is due, if the schedule counts.
    ``tolerance``: the half-width of the bandwidth about the goal, in the metric's unit.
    ``attempts``: the number of attempts the feedback summarises.
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


class Spread(msgspec.Struct, frozen=True):
    """The trials behind a mean: ``n``, their number, and ``sd``, the SD between them; 0 for one
    trial.

    ``n`` is 0 if a trial is doubtful and the mean includes it, so that it cannot be compared.
    """

    n: int
    sd: float


class AttemptEnded(Message, frozen=True, kw_only=True):
    """A scored attempt. ``feedback`` is ``none`` if none was due; ``choice`` says why, and how it
    is given.

    ``goal``: the value the metric was compared with; None for an attempt without goal, whose
    ``outcome`` is ``none``. ``qualities``: means of the task's qualities (knowledge of
    performance), by name. ``spreads``: of the trials behind the metric and the qualities, by name;
    none before rules 5.
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
    spreads: dict[str, Spread] = {}
    choice: FeedbackChoice | None = None
    started: int
    ended: int
    condition: str = ""


class LevelChanged(Message, frozen=True, kw_only=True):
    """The level of the next attempt changed.

    ``reason``: ``operator``, ``mark``, the outcome of an attempt (``success``, ``failure``) under
    the default difficulty policy, or else the policy's name. ``why``: one plain sentence.
    """

    previous: int
    level: int
    reason: str
    why: str = ""


class GoalChanged(Message, frozen=True, kw_only=True):
    """The goal of the next attempt changed otherwise than with its level.

    ``previous`` and ``goal`` are values of the metric, in its ``unit``. ``reason``: the difficulty
    policy's name. ``why``: one plain sentence.
    """

    previous: float
    goal: float
    unit: str
    reason: str
    why: str


class Feedback(Message, frozen=True, kw_only=True):
    """Feedback on an attempt that the agent should give.

    ``reason``: ``goal`` (reached), ``missed``, ``band`` (close to the goal), ``accuracy`` (too
    low), ``empty`` (no response could be timed), and in a race ``won``, ``lost``, ``drawn``.
    ``remark``: the task's explanation of ``accuracy`` or ``empty``. ``advice``: the task's advice
    if prompts stayed unanswered (see `Task.when_to_respond`); else empty. ``correction``: the
    task's sentence on how to move, said at the end. ``won``: trials won in a race. ``reached``: the
    number of summarised attempts that reached their goal; of several, ``metric`` and ``goal`` are
    means. ``due``: when to give it (ns); ``choice``: how, and why.
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
    advice: str = ""
    correction: str = ""
    condition: str = ""


StepStatus = Literal["answered", "declined", "skipped", "done"]


class StepEnded(Message, frozen=True, kw_only=True):
    """A step between attempts is over.

    ``number``: of the session's steps, from 1. ``attempt``: number of attempts before it, without
    practice. ``name``, ``kind``, ``text``, ``labels``: as it was asked. ``status``: ``answered``,
    ``declined`` (would rather not say), ``skipped`` (by an operator), ``done`` (read, or over).
    ``answer``: a point of a scale, 0 to 100 on a line, the words of an option or of several, or a
    text; None without one. ``shown``, ``ended``: from when to when (ns).
    """

    number: int
    attempt: int
    name: str
    kind: StepKind
    text: str
    labels: tuple[str, ...] = ()
    status: StepStatus
    answer: Answer = None
    shown: int
    ended: int


TakenBackKind = Literal["answer", "attempt", "level", "hold", "setting", "mark", "note"]


class TakenBack(Message, frozen=True, kw_only=True):
    """A person took back what they had just done. It counts for nothing any more.

    ``what``: an ``answer`` (the question is asked again), an ``attempt`` (it waits to be begun,
    under the next number), the ``level``, ``hold`` (the level was held, or released), a
    ``setting``, a ``mark``, a ``note``. ``actor``: who did both. ``number``: of the step or the
    attempt. ``act``: id of the command, if it carries one. ``done``: when it was done (ns).
    """

    what: TakenBackKind
    actor: str
    number: int = 0
    act: str = ""
    done: int


EndStatus = Literal["completed", "aborted", "refused"]


class SessionEnded(Message, frozen=True, kw_only=True):
    """The session is over.

    ``completed``: every attempt is done. ``aborted``: a person ended it. ``refused``: a required
    answer was not given, or it was ended before.
    """

    status: EndStatus


class Fault(Message, frozen=True, kw_only=True):
    """A handler raised an exception at ``place``. The trace is logged; participants never see
    it.
    """

    node: str
    topic: str
    error: str
    place: str = ""
    trace: str


class LevelRequest(Message, frozen=True, kw_only=True):
    """Ask to change the level. ``is_last``: after the last attempt, when there is no time to ask an
    operator.
    """

    change: LevelChanged
    is_last: bool


class LevelReply(Message, frozen=True, kw_only=True):
    """Reply to LevelRequest. ``happens``: the level changes now; else it waits for an operator, or
    is refused.
    """

    happens: bool


class Recall(Message, frozen=True, kw_only=True):
    """Ask for the scored attempts so far, practice excluded: at ``level`` and in ``condition``, or
    all of them.
    """

    level: int | None = None
    condition: str | None = None


class RecalledAttempts(Message, frozen=True, kw_only=True):
    """Reply to Recall, oldest first. ``earlier_best``: best result of earlier sessions at the
    requested level.
    """

    attempts: tuple[AttemptEnded, ...]
    earlier_best: float | None = None

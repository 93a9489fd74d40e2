"""Phases of a session, and the `messages.Waiting` that each publishes."""

from enum import Enum, auto

from sar_tui.loop.attempts import Attempts
from sar_tui.loop.task import Task
from sar_tui.model.messages import Waiting

REQUEST_KEY = "tab"
"""Key with which a participant requests feedback on the last attempt, under the schedule
``request``.
"""


class Phase(Enum):
    """Phase of a session."""

    INSTRUCTIONS = auto()
    READY = auto()  # waits for Enter, which begins an attempt
    AGENT = auto()  # the agent speaks or moves; the trial continues when it is still
    START = auto()  # waits for the participant to start the trial
    QUIET = auto()  # waits until no key has been pressed for a moment
    FOREPERIOD = auto()
    STORING = auto()  # the foreperiod is over, but the last trial is not on disk yet
    ONSET = auto()  # the prompt is on its way to the screen
    RESPONSE = auto()
    RESULT = auto()  # the trial is over; the answer to it is shown
    FEEDBACK = auto()  # the attempt is over; its feedback comes after a delay
    STEP = auto()  # a question, or another step between attempts
    REST = auto()  # a rest that must be taken, before the next attempt
    PAUSED = auto()
    REVIEW = auto()  # every attempt is done; waits for Enter
    CLOSING = auto()  # the session is over, but the last trial is not on disk yet
    ENDED = auto()
    BROKEN = auto()  # the task or the program has failed


BEFORE_PROMPT = {Phase.QUIET, Phase.FOREPERIOD, Phase.STORING}
IN_TRIAL = {Phase.AGENT, Phase.START, *BEFORE_PROMPT, Phase.ONSET, Phase.RESPONSE}
OVER = {Phase.CLOSING, Phase.ENDED, Phase.BROKEN}
ENTER_RESUMES = ("interrupted", "restored")
PAUSES: dict[str, str] = {"interrupted": "enter", "restored": "enter", "sensor": "sensor"}
"""Events that end a pause, by its reason; a pause for any other reason ends with a command to
resume.
"""
VISIT_ASKED = "visit"
"""Reason of a pause in which the participant is asked whether somebody may watch."""
ASKABLE = {Phase.INSTRUCTIONS, Phase.READY, Phase.REST}
"""Phases that this question may interrupt."""
ASKABLE_PAUSES = ("", "tired", "interrupted")
"""Reasons of pauses that it may interrupt."""
LEFT = "left"
"""Reason of a pause in which the session was left on purpose: a later run begins as after an
interruption.
"""
MARKABLE = {
    Phase.RESULT,
    Phase.AGENT,
    Phase.START,
    Phase.FEEDBACK,
    Phase.STEP,
    Phase.REST,
    Phase.READY,
    Phase.REVIEW,
}
"""Phases in which a mark applies to the last trial."""
REQUESTABLE = {Phase.REST, Phase.READY, Phase.REVIEW}
"""Phases in which a participant may request feedback on the last attempt."""
WAITS: dict[Phase, tuple[str, str]] = {
    Phase.INSTRUCTIONS: ("enter", "instructions"),
    Phase.READY: ("enter", "attempt"),
    Phase.AGENT: ("agent", "trial"),
    Phase.START: ("start", "trial"),
    Phase.QUIET: ("quiet", "trial"),
    Phase.FOREPERIOD: ("foreperiod", "trial"),
    Phase.STORING: ("storage", "trial"),
    Phase.ONSET: ("response", "trial"),
    Phase.RESULT: ("result", "trial"),
    Phase.FEEDBACK: ("answer", "answer"),
    Phase.STEP: ("step", "step"),
    Phase.REST: ("rest", "rest"),
    Phase.REVIEW: ("enter", "review"),
    Phase.CLOSING: ("storage", "ended"),
    Phase.ENDED: ("nothing", "ended"),
    Phase.BROKEN: ("nothing", "broken"),
}
"""``what`` and ``stage`` of the message of each phase (see `messages.Waiting`)."""


def waiting_message(
    phase: Phase,
    attempts: Attempts,
    task: Task,
    *,
    notice: str,
    reason: str,
    detail: str,
    seat: str = "A",
    until: int = 0,
) -> Waiting:
    """Return the message that a session publishes when it enters ``phase``.

    Args:
        phase: the phase that is entered.
        attempts: gives the attempt, the trial, and the level.
        task: gives the texts.
        notice: shown to the participant first.
        reason, detail, seat, until: as in `messages.Waiting`.
    """
    what, stage = (
        (PAUSES.get(reason, "resume"), "paused") if phase is Phase.PAUSED else WAITS[phase]
    )
    goal, trials = "", 0
    if phase is not Phase.BROKEN:  # the failed method is not called again
        trials = attempts.trials
        if phase is Phase.START:
            goal = text_of(task.start(attempts.level), "start")
        elif stage != "trial":
            goal = text_of(attempts.goal, "goal")
    return Waiting(
        seat=seat,
        what=what,  # type: ignore[arg-type]
        stage=stage,  # type: ignore[arg-type]
        attempt=attempts.attempt,
        trial=attempts.trial - (phase is Phase.RESULT),
        level=attempts.level,
        attempt_name=attempts.name,
        trials=trials,
        goal=goal,
        notice=notice,
        reason=reason,
        detail=detail,
        ask=REQUEST_KEY if phase in REQUESTABLE and attempts.can_request_feedback else "",
        until=until,
        restarts=attempts.state.restarts,
    )


def text_of(value: object, method: str) -> str:
    """Return what a method of a task returned. Raises TypeError if it is not a text: the screen
    would stay blank.
    """
    if not isinstance(value, str):
        raise TypeError(f"{method}() returned {value!r:.60}, not a text")
    return value

"""What a session says while it waits: for whom or what, where it stands, and what is aimed at there."""

from sar_tui.framework.attempts import Attempts
from sar_tui.framework.messages import Waiting
from sar_tui.framework.session_phase import PAUSES, WAITS, Phase
from sar_tui.framework.task import Task

ASK_KEY = "tab"
"""The key with which a participant asks how the last attempt went, where feedback is given on request."""


def waiting(
    phase: Phase, attempts: Attempts, task: Task, *, notice: str, reason: str, detail: str, seat: str = "A"
) -> Waiting:
    """The message for a phase.

    Args:
        phase: where the session stands.
        course: how far it has come.
        task: whose words are said.
        notice: what the participant has to know first.
        reason, detail, seat: as in `messages.Waiting`.
    """
    what, stage = (PAUSES.get(reason, "resume"), "paused") if phase is Phase.PAUSED else WAITS[phase]
    goal = "" if stage == "trial" else task.goal(attempts.level)
    return Waiting(
        seat=seat,
        what=what,  # type: ignore[arg-type]
        stage=stage,  # type: ignore[arg-type]
        attempt=attempts.attempt,
        trial=attempts.trial,
        level=attempts.level,
        attempt_name=attempts.name,
        trials=task.trials_per_attempt,
        goal=task.start(attempts.level) if phase is Phase.START else goal,
        notice=notice,
        reason=reason,
        detail=detail,
        ask=ASK_KEY if phase in (Phase.READY, Phase.REVIEW) and attempts.unanswered else "",
    )

"""Settings of an operator's say in a session."""

from typing import Annotated, Literal

from sar_tui.framework.declaration import Settings, meta
from sar_tui.framework.messages import Mode


class OperatorSettings(Settings, frozen=True, kw_only=True):
    """Mode of each kind of action, and time limits of the operator."""

    operator_feedback: Annotated[
        Mode,
        meta("Feedback mode", help="With an operator: autonomous, the agent gives it; veto, unless it is stopped in "
             "time; approve, on a key; manual, the operator alone.", group="Operator"),
    ] = "autonomous"  # fmt: skip
    operator_encouragement: Annotated[
        Mode,
        meta("Encouragement mode", help="As for feedback; also reminders of rest.", group="Operator"),
    ] = "autonomous"
    operator_instruction: Annotated[
        Mode,
        meta("Instruction mode", help="As for feedback; also greeting and goodbye.", group="Operator"),
    ] = "autonomous"
    operator_gesture: Annotated[
        Mode,
        meta("Gesture mode", help="As for feedback; autonomous: they go with their words.", group="Operator"),
    ] = "autonomous"
    operator_difficulty: Annotated[
        Mode,
        meta("Level mode", help="As for feedback.", group="Operator"),
    ] = "autonomous"
    operator_time_ms: Annotated[
        int,
        meta("Time to decide", "ms", "How long veto and approve wait. With a feedback delay, feedback waits for that.",
             group="Operator", ge=200, le=120_000),
    ] = 4000  # fmt: skip
    operator_timeout: Annotated[
        Literal["act", "drop"],
        meta("Timeout of approve", help="When nobody decides in time. act: the agent goes on as if it were alone. "
             "drop: nothing is said.", group="Operator"),
    ] = "act"  # fmt: skip
    operator_lost: Annotated[
        Literal["autonomous", "silent"],
        meta("Agent without operator", help="If none is there, or none is heard any more. silent: what would need one "
             "is left out.", group="Operator"),
    ] = "autonomous"  # fmt: skip
    operator_lost_ms: Annotated[
        int,
        meta("Time until lost", "ms", "An operator is lost whose program gave no sign of life for so long.",
             group="Operator", ge=500, le=60_000),
    ] = 2000  # fmt: skip
    filler: Annotated[
        Literal["operator", "always", "never"],
        meta("Filler", help="A word after a second without an answer that is due. operator: while one decides; always: "
             "also while a feedback delay passes, so that it does not tell the two apart.", group="Operator"),
    ] = "operator"  # fmt: skip

"""Settings of the operator's role in a session."""

from typing import Annotated, Any, Literal

from sar_tui.model.messages import Mode
from sar_tui.rules.declaration import Settings, meta


def _mode(title: str, help: str) -> Any:
    return meta(title, help=help, group="Operator")


class OperatorSettings(Settings, frozen=True, kw_only=True):
    """Mode of each kind of action, and time limits of the operator.

    Adults read English non-fiction silently at 238 words a minute, 252 ms a word (Brysbaert 2019).
    """

    operator_joins: Annotated[
        bool,
        meta(
            "Operators can join",
            help="On this computer, with `sar-tui wizard`, from the beginning of a session to its "
            "end.",
            group="Operator",
            personal=True,
        ),
    ] = False
    operator_feedback: Annotated[
        Mode,
        _mode(
            "Feedback mode",
            "With an operator: autonomous, the agent acts; veto, it acts unless stopped in time; "
            "approve, it acts when a key is pressed; manual, only the operator acts.",
        ),
    ] = "autonomous"
    operator_encouragement: Annotated[
        Mode, _mode("Encouragement mode", "As for feedback; includes reminders of rest.")
    ] = "autonomous"
    operator_instruction: Annotated[
        Mode, _mode("Instruction mode", "As for feedback; includes greeting and goodbye.")
    ] = "autonomous"
    operator_gesture: Annotated[
        Mode, _mode("Gesture mode", "As for feedback; autonomous: gestures go with their text.")
    ] = "autonomous"
    operator_difficulty: Annotated[Mode, _mode("Level mode", "As for feedback.")] = "autonomous"
    operator_time_ms: Annotated[
        int,
        meta(
            "Time to decide",
            "ms",
            "Shortest waiting time of veto and approve; more if there is more to read. For "
            "feedback with a delay, that "
            "delay.",
            group="Operator",
            ge=200,
            le=120_000,
        ),
    ] = 4000
    operator_ms_per_word: Annotated[
        int,
        meta(
            "Reading time per word",
            "ms",
            "The operator has this time for each word, and 2 s to choose. 0: always the time "
            "above.",
            group="Operator",
            ge=0,
            le=2000,
        ),
    ] = 250
    operator_timeout: Annotated[
        Literal["act", "drop"],
        meta(
            "Timeout of approve",
            help="If nobody decides in time. act: the agent acts as if it were alone. drop: "
            "nothing is said.",
            group="Operator",
        ),
    ] = "act"
    operator_lost: Annotated[
        Literal["autonomous", "silent"],
        meta(
            "Agent without operator",
            help="If no operator is connected, or the connection is lost. silent: what needs an "
            "operator is dropped.",
            group="Operator",
        ),
    ] = "autonomous"
    operator_lost_ms: Annotated[
        int,
        meta(
            "Time until lost",
            "ms",
            "The operator counts as lost after this time without a sign of life from the panel or "
            "its terminal.",
            group="Operator",
            ge=500,
            le=60_000,
        ),
    ] = 2000
    filler: Annotated[
        Literal["operator", "always", "never"],
        meta(
            "Filler",
            help="Said after one second of waiting for feedback. operator: while an operator "
            "decides. always: "
            "also during a feedback delay, so that the two cannot be told apart. never: nothing "
            "is said.",
            group="Operator",
        ),
    ] = "operator"

"""Settings of feedback that every schedule shares."""

from typing import TYPE_CHECKING, Annotated, Literal

from sar_tui.model.trial_types import LONGEST_SHOW_MS
from sar_tui.rules.declaration import Settings, meta
from sar_tui.rules.feedback import POLICIES

if TYPE_CHECKING:
    ScheduleName = str
else:
    ScheduleName = Literal[tuple(POLICIES)]


class ScheduleSettings(Settings, frozen=True, kw_only=True):
    """The schedule of feedback."""

    feedback_schedule: Annotated[
        ScheduleName,
        meta(
            "Feedback",
            help="every: after every n attempts. faded: less often with success. bandwidth: only "
            "away from "
            "the goal. summary: on the last n attempts. request: when the participant asks (Tab). "
            "none: never.",
            group="Feedback",
        ),
    ] = "every"


class FeedbackSettings(Settings, frozen=True, kw_only=True):
    """Form, comparison and delay of feedback."""

    feedback_form: Annotated[
        Literal["qualitative", "quantitative", "both"],
        meta("Feedback form", help="In words, in figures, or both.", group="Feedback"),
    ] = "both"
    feedback_compared_with: Annotated[
        Literal["last attempt", "best attempt", "session's mean", "goal"],
        meta(
            "Compared with",
            help="Figures are compared with results at the same level, or with the goal.",
            group="Feedback",
        ),
    ] = "last attempt"
    feedback_delay_ms: Annotated[
        int,
        meta(
            "Feedback delay",
            "ms",
            "Time from the end of an attempt to its feedback.",
            ge=0,
            le=60_000,
            group="Feedback",
        ),
    ] = 0
    trial_feedback_ms: Annotated[
        int,
        meta(
            "Sign after each prompt",
            "ms",
            "A tick or a cross is shown this long after each prompt, unless the task shows "
            "something else; 0: never.",
            ge=0,
            le=LONGEST_SHOW_MS,
            group="Feedback",
        ),
    ] = 0

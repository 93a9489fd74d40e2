"""Settings of the goal that an attempt is judged against."""

from typing import Annotated

from sar_tui.rules.declaration import Settings, meta


class GoalSettings(Settings, frozen=True, kw_only=True):
    """Threshold, neutral band and accuracy of a successful attempt."""

    threshold: Annotated[
        float,
        meta(
            "Goal",
            help="The result of an attempt must be better than this; equal is not enough.",
            ge=0,
            le=1e6,
            group="Difficulty",
        ),
    ] = 1000.0
    neutral_band: Annotated[
        float,
        meta(
            "Neutral band",
            help="Feedback is neutral within this distance of the goal, on either side.",
            ge=0,
            le=1e6,
            group="Difficulty",
        ),
    ] = 10.0
    min_accuracy: Annotated[
        float,
        meta(
            "Minimum accuracy",
            help="Share of right responses that an attempt needs to succeed, 0 to 1.",
            ge=0,
            le=1,
            group="Difficulty",
        ),
    ] = 0.8

"""One level up after N successes in a row, one down after M failures in a row (thesis 4.2.1).

With one of each, the level settles where half of the attempts succeed (Levitt 1971). If
neighbouring levels are far apart, that half is one of sure successes and sure failures in turn.
"""

from typing import Annotated, NamedTuple

from sar_tui.model.messages import Outcome
from sar_tui.rules.declaration import Settings, meta
from sar_tui.rules.difficulty.policy import Bounds, Difficulty, DifficultyPolicy, ScoredAttempt


class OneUpOneDownSettings(Settings, frozen=True, kw_only=True):
    """Settings of the difficulty policy ``one-up-one-down``."""

    consecutive_successes: Annotated[
        int,
        meta(
            "Successes before harder",
            help="For one-up-one-down: this many successes in a row raise the level by one.",
            ge=1,
            le=20,
            group="Difficulty",
        ),
    ] = 1
    consecutive_failures: Annotated[
        int,
        meta(
            "Failures before easier",
            help="For one-up-one-down: this many failures in a row lower the level by one.",
            ge=1,
            le=20,
            group="Difficulty",
        ),
    ] = 1


class Streak(NamedTuple):
    """Attempts in a row with the same outcome since the level last changed."""

    outcome: Outcome
    length: int


def step(
    state: Difficulty, attempt: ScoredAttempt, settings: OneUpOneDownSettings, bounds: Bounds
) -> Difficulty:
    """Return the difficulty after one more attempt.

    A full streak moves the level, within its bounds, and the count starts again.
    """
    before = state.memory
    streak = Streak(
        attempt.outcome, before.length + 1 if before and before.outcome == attempt.outcome else 1
    )
    if attempt.outcome == "success":
        needed, level, done = (
            settings.consecutive_successes,
            min(state.level + 1, bounds.highest),
            "reached",
        )
    else:
        needed, level, done = (
            settings.consecutive_failures,
            max(state.level - 1, bounds.lowest),
            "missed",
        )
    if streak.length < needed:
        return Difficulty(state.level, streak)
    times = f" {needed} times in a row" if needed > 1 else ""
    return Difficulty(level, why=f"Goal {done}{times}." if level != state.level else "")


POLICY = DifficultyPolicy(
    "One level up after a success, one down after a failure, or after several in a row.",
    OneUpOneDownSettings,
    step,
)

"""One level up after N successes in a row, one down after M failures in a row (thesis 4.2.1)."""

from typing import Annotated, NamedTuple

from sar_tui.framework.declaration import Settings, meta
from sar_tui.framework.messages import Outcome
from sar_tui.framework.policies.difficulty.policy import Bounds, Difficulty, DifficultyPolicy


class ConsecutiveSettings(Settings, frozen=True, kw_only=True):
    """Settings of the difficulty policy ``consecutive``."""

    consecutive_successes: Annotated[
        int,
        meta(
            "Successes before harder",
            help="This many successes in a row raise the level by one.",
            ge=1,
            le=20,
            group="Difficulty",
        ),
    ] = 1
    consecutive_failures: Annotated[
        int,
        meta(
            "Failures before easier",
            help="This many failures in a row lower the level by one.",
            ge=1,
            le=20,
            group="Difficulty",
        ),
    ] = 1


class Streak(NamedTuple):
    """Attempts in a row with the same outcome since the level last changed."""

    outcome: Outcome
    length: int


def step(state: Difficulty, outcome: Outcome, settings: ConsecutiveSettings, bounds: Bounds) -> Difficulty:
    """Return the difficulty after one more attempt.

    A full streak moves the level, within its bounds, and the count starts again.
    """
    before = state.memory
    streak = Streak(outcome, before.length + 1 if before and before.outcome == outcome else 1)
    if outcome == "success":
        needed, level = settings.consecutive_successes, min(state.level + 1, bounds.highest)
    else:
        needed, level = settings.consecutive_failures, max(state.level - 1, bounds.lowest)
    return Difficulty(state.level, streak) if streak.length < needed else Difficulty(level)


POLICY = DifficultyPolicy(step, ConsecutiveSettings)

"""The level stays, unless an operator sets it."""

from sar_tui.framework.declaration import Settings
from sar_tui.framework.messages import Outcome
from sar_tui.framework.policies.difficulty.policy import Bounds, Difficulty, DifficultyPolicy


def step(state: Difficulty, outcome: Outcome, settings: Settings, bounds: Bounds) -> Difficulty:
    """Return the difficulty unchanged."""
    return state


POLICY = DifficultyPolicy(step)

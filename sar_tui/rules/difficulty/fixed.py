"""The level stays, unless an operator sets it."""

from sar_tui.rules.difficulty.policy import DifficultyPolicy

POLICY = DifficultyPolicy("Level and goal stay as they are set.")

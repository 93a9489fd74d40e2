"""Policies of difficulty: the level of the next attempt, or its goal.

Each module of this package with a ``POLICY`` is a policy. Its file name, with hyphens, is the value
of ``difficulty_policy``; its parameters appear on the settings form of every task.
"""

from sar_tui.rules import registry
from sar_tui.rules.difficulty.policy import DifficultyPolicy

POLICIES = registry.find(__name__, __path__, DifficultyPolicy)
BY_OUTCOME = "one-up-one-down"
"""The default policy. Each change of its level has the outcome of an attempt as its reason."""

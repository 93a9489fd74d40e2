"""Policies of difficulty: the level of the next attempt.

Each module of this package with a ``POLICY`` is a policy. Its file name is the value of ``difficulty_policy``; its
parameters appear on the settings form of every task.
"""

from sar_tui.framework.policies import registry
from sar_tui.framework.policies.difficulty.policy import DifficultyPolicy

POLICIES = registry.find(__name__, __path__, DifficultyPolicy)

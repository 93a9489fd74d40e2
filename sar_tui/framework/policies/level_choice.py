"""The level of an attempt, by the policy of difficulty that is set."""

from sar_tui.framework.messages import Outcome
from sar_tui.framework.parameters import TaskParameters
from sar_tui.framework.policies import registry
from sar_tui.framework.policies.difficulty import POLICIES
from sar_tui.framework.policies.difficulty.policy import Bounds, Difficulty


def start(parameters: TaskParameters, levels: int) -> Difficulty:
    """Return the difficulty of the first attempt: the start level, or the task's last if it has fewer."""
    return Difficulty(level=min(parameters.start_level, levels))


def step(state: Difficulty, outcome: Outcome, parameters: TaskParameters, levels: int) -> Difficulty:
    """Return the difficulty after one more attempt, by the policy that is set.

    Args:
        state: before the attempt.
        outcome: of the attempt.
        parameters: of the session.
        levels: number of levels that the task has.
    """
    policy = POLICIES[parameters.difficulty_policy]
    bounds = Bounds(min(parameters.min_level, levels), min(parameters.max_level, levels))
    return policy.step(state, outcome, registry.own_settings(policy.settings, parameters), bounds)

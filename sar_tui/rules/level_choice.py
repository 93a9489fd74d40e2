"""The level and the goal of an attempt, by the policy of difficulty that is set."""

from collections.abc import Sequence

from sar_tui.model.messages import Outcome
from sar_tui.model.trial_types import Metric
from sar_tui.rules.difficulty import BY_OUTCOME, Bounds, Difficulty, Goal, ScoredAttempt
from sar_tui.rules.parameters import TaskParameters
from sar_tui.rules.policies import DIFFICULTY, own_settings


def start(parameters: TaskParameters, levels: int) -> Difficulty:
    """Return the difficulty of the first attempt; if the task has fewer levels, its last."""
    policy = DIFFICULTY[parameters.difficulty_policy]
    settings = own_settings(policy.settings, parameters)
    return Difficulty(
        level=policy.start(parameters.start_level, settings, bounds(parameters, levels))
    )


def step(
    state: Difficulty, attempt: ScoredAttempt, parameters: TaskParameters, levels: int
) -> Difficulty:
    """Return the difficulty after one more attempt, by the policy that is set.

    Args:
        state: before the attempt.
        attempt: its outcome and result.
        parameters: of the session.
        levels: number of levels that the task has.
    """
    policy = DIFFICULTY[parameters.difficulty_policy]
    return policy.step(
        state,
        attempt,
        own_settings(policy.settings, parameters),
        bounds(parameters, levels),
    )


def moves_goal(parameters: TaskParameters) -> bool:
    """Return True if the policy that is set makes goals of its own."""
    return DIFFICULTY[parameters.difficulty_policy].goal is not None


def moves_level(parameters: TaskParameters) -> bool:
    """Return True if the level follows the person, rather than an order of its own."""
    return DIFFICULTY[parameters.difficulty_policy].moves_level


def goal(
    results: Sequence[float | None], metric: Metric, parameters: TaskParameters
) -> Goal | None:
    """Return the goal of the next attempt, from the results so far at its level; None: the task's
    own.
    """
    policy = DIFFICULTY[parameters.difficulty_policy]
    if policy.goal is None:
        return None
    return policy.goal(results, metric.better, own_settings(policy.settings, parameters))


def reason(parameters: TaskParameters, outcome: Outcome) -> str:
    """Return the reason of a change of level, as in `messages.LevelChanged`."""
    name = parameters.difficulty_policy
    return outcome if name == BY_OUTCOME else name


def bounds(parameters: TaskParameters, levels: int) -> Bounds:
    """Return the lowest and highest level under these parameters, of a task with so many levels."""
    return Bounds(min(parameters.min_level, levels), min(parameters.max_level, levels))

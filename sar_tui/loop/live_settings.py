"""Settings that a therapist may change during a session, from the next attempt on. Pure."""

import copy

import msgspec

from sar_tui.loop.task import Task
from sar_tui.plugin_calls import PLUGIN_ERRORS
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.feedback import POLICIES
from sar_tui.rules.level_choice import moves_goal
from sar_tui.rules.parameters import TaskParameters, build, changed

GOAL, FEEDBACK_EVERY = "threshold", "feedback_every"
NAMES = (GOAL, FEEDBACK_EVERY)


def adjustable(task: Task) -> tuple[str, ...]:
    """Return the names of the settings that have an effect in this session, as it is set up."""
    schedule = POLICIES[task.parameters.feedback_schedule]
    has_effect = {
        GOAL: _goal_follows(task),
        FEEDBACK_EVERY: FEEDBACK_EVERY in schedule.settings.__struct_fields__,
    }
    return tuple(name for name in NAMES if has_effect[name])


def with_setting(parameters: TaskParameters, name: str, value: object) -> TaskParameters:
    """Return parameters with another value, typed or as text. Raises ParameterError if it is out of
    bounds.
    """
    if name not in NAMES:
        raise ParameterError({name: f"{name} cannot be changed during a session."})
    return build(type(parameters), {**changed(parameters), name: value})


def _goal_follows(task: Task) -> bool:
    """Return True if the goals depend on the threshold: they may be a task's own, or follow a
    person's results.
    """
    if moves_goal(task.parameters):
        return False
    other = copy.copy(task)
    other.parameters = msgspec.structs.replace(
        task.parameters, threshold=task.parameters.threshold * 2 + 1
    )
    try:
        levels = range(1, task.levels + 1)
        return any(other.goal_value(level) != task.goal_value(level) for level in levels)
    except PLUGIN_ERRORS:
        return False

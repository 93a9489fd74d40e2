"""What a session tells of itself to whoever joins it."""

import msgspec

from sar_tui.framework.task import Task
from sar_tui.link.peer import MarkKey, Welcome


def about(task: Task, session: str, link: str, participants: dict[str, str]) -> Welcome:
    """The welcome of a session, but for who it is to.

    Args:
        task: with its parameters.
        session: its id; ``link``: that of its link.
        participants: their codes, by seat.
    """
    parameters = task.parameters
    return Welcome(
        link=link,
        session=session,
        task=task.name,
        title=task.title,
        participants=participants,
        name="",
        role="observer",
        unit=task.metric.unit,
        decimals=task.metric.decimals,
        levels=task.levels,
        attempts=parameters.practice_attempts + parameters.attempts,
        trials=task.trials_per_attempt,
        marks=tuple(MarkKey(mark.name, mark.title) for mark in task.marks),
        parameters=msgspec.to_builtins(parameters),
    )

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
    called = participants if task.address == "code" else {seat: task.seat_name(seat) for seat in participants}
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
        called=called if len(participants) > 1 else {},
        parameters=msgspec.to_builtins(parameters),
    )

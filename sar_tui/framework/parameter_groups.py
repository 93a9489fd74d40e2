"""The headings under which a task's parameters stand, on the settings form and in lists."""

from sar_tui.framework.declaration import Field
from sar_tui.framework.parameters import TaskParameters, fields


def grouped(parameters: type[TaskParameters]) -> dict[str, tuple[Field, ...]]:
    """The declared parameters by heading, in the order in which people are to read them.

    First the task's own under ``""``, then the headings that only this task has, then those common to every task.
    """
    common = list(dict.fromkeys(field.group for field in fields(TaskParameters)))
    found: dict[str, list[Field]] = {}
    for field in fields(parameters):
        found.setdefault(field.group, []).append(field)
    ranks = {heading: common.index(heading) + 1 if heading in common else bool(heading) - 1 for heading in found}
    return {heading: tuple(found[heading]) for heading in sorted(found, key=ranks.__getitem__)}

"""The tasks on the first screen, by what they train."""

from itertools import groupby

from textual.content import Content
from textual.widgets.option_list import Option

from sar_tui.plugins import Catalogue, PluginError
from sar_tui.widgets.marked_list import PickList

_OTHERS = "Others"
"""Heading of tasks that do not say what they train."""


def list_tasks(tasks: PickList, catalogue: Catalogue) -> None:
    """List each task below a heading of what it trains; those that do not load are last.

    Where no task says what it trains there are no headings. The chosen one says what is done in it.
    """
    known: list[tuple[str, str, str]] = []
    broken = []
    for name in catalogue.task_names():
        try:
            task = catalogue.task(name)
        except PluginError:
            broken.append(Option(f"{name} (does not load)", id=name, disabled=True))
        else:
            known.append((task.trains, task.title, name))
            tasks.summaries[name] = (task.title, task.summary)
    known.sort(key=lambda task: (not task[0], *task))
    options = []
    for trains, group in groupby(known, key=lambda task: task[0]):
        if known[0][0]:
            options.append(Option(Content.styled(trains or _OTHERS, "$text-muted"), disabled=True))
        options += [Option(title, id=name) for _, title, name in group]
    tasks.add_options([*options, *broken])

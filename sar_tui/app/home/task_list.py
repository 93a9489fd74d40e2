"""The tasks on the first screen, by what they train; the chosen one says what is done in it."""

import textwrap
from itertools import groupby

from textual.content import Content
from textual.widgets.option_list import Option

from sar_tui.plugins import Catalogue, PluginError
from sar_tui.widgets.marked_list import PickList

_OTHERS = "Others"
"""Heading of tasks that do not say what they train."""
_WIDTH = 33
"""Characters of a line of a summary."""


class TaskList(PickList):
    """A list of tasks that opens while it has the focus."""

    DEFAULT_CSS = f"""
    TaskList:focus {{ width: {_WIDTH + 8}; }}
    """

    def __init__(self, *, id: str) -> None:
        super().__init__(id=id, markup=False)
        self._told: dict[str, tuple[str, str]] = {}
        self._expanded = ""

    def fill(self, catalogue: Catalogue) -> None:
        """List each task below a heading of what it trains; those that do not load are last.

        Where no task says what it trains there are no headings.
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
                self._told[name] = (task.title, task.summary)
        known.sort(key=lambda task: (not task[0], *task))
        options = []
        for trains, tasks in groupby(known, key=lambda task: task[0]):
            if known[0][0]:
                options.append(
                    Option(Content.styled(trains or _OTHERS, "$text-muted"), disabled=True)
                )
            options += [Option(title, id=name) for _, title, name in tasks]
        self.add_options([*options, *broken])

    def watch_has_focus(self, has_focus: bool) -> None:
        super().watch_has_focus(has_focus)
        self._expand()

    def watch_highlighted(self, highlighted: int | None) -> None:
        super().watch_highlighted(highlighted)
        self._expand()

    def _expand(self) -> None:
        """Say under the chosen task what is done in it, while the list is open."""
        chosen = (self.chosen or "") if self.has_focus else ""
        if chosen == self._expanded:
            return
        for name in (self._expanded, chosen):
            if name in self._told:
                title, summary = self._told[name]
                told = (
                    "".join(f"\n  {line}" for line in textwrap.wrap(summary, _WIDTH))
                    if name == chosen
                    else ""
                )
                self.replace_option_prompt(
                    name, Content.assemble(title, (told, "$text-muted not bold"))
                )
        self._expanded = chosen
        if all(option.disabled for option in self.options[(self.highlighted or 0) + 1 :]):
            self.scroll_end(animate=False)  # shows those below that do not load
        else:
            self.scroll_to_highlight()

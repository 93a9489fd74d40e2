"""Help: the purpose of a screen, and its keys."""

from typing import ClassVar

from rich.table import Table
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import VerticalScroll
from textual.screen import ModalScreen, Screen
from textual.widgets import Static

from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.widgets.language import language_of


class HelpScreen(DismissedOnce[None], ModalScreen[None]):
    """Lists the keys of the screen below it."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape,enter,space,f1,question_mark,q", "dismiss", "Close", id="help-close")
    ]

    def __init__(self, about: Screen[object]) -> None:
        super().__init__()
        self._about = about

    def compose(self) -> ComposeResult:
        tr = language_of(self.app)
        with VerticalScroll(id="help"):
            yield Static(getattr(self._about, "help_text", ""), markup=False)
            yield Static(self._keys())
            yield Static(tr("Press Enter to close this."), classes="muted", markup=False)

    def _keys(self) -> Table:
        table, tr = Table.grid(padding=(0, 2)), language_of(self.app)
        seen = set()
        for binding in self._about.active_bindings.values():
            name = binding.binding.description
            if binding.binding.show and binding.enabled and name and name not in seen:
                seen.add(name)
                table.add_row(self.app.get_key_display(binding.binding), tr(name).capitalize())
        return table

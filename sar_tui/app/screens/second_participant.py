"""Asks for the second participant of a task for two."""

from typing import Any, ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Static
from textual.widgets.option_list import Option

from sar_tui.store import participants
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.widgets.option_list import OptionList

_NEW = "+"


class SecondParticipantScreen(DismissedOnce[str | None], ModalScreen[str | None]):
    """Asks for the participant on the right; its result is their code, or None.

    Args:
        first: code of the participant on the left, who is not offered.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss(None)", "Cancel", id="cancel")
    ]

    app: Any

    def __init__(self, first: str) -> None:
        super().__init__()
        self._first = first

    def compose(self) -> ComposeResult:
        with Vertical(id="second-participant"):
            yield Static("Who sits on the right?", classes="headline")
            yield Static(f"{self._first} sits on the left.", markup=False)
            yield OptionList(id="others", markup=False)
            yield Static("Arrows and Enter to choose, Esc to cancel.", classes="muted")

    def on_mount(self) -> None:
        self._list()

    def _list(self) -> None:
        others = self.query_one("#others", OptionList)
        others.clear_options()
        codes = [code for code in participants.codes(self.app.database) if code != self._first]
        others.add_options([Option(code, id=code) for code in codes])
        others.add_option(Option("+ New participant", id=_NEW))
        others.highlighted = 0

    @on(OptionList.OptionSelected)
    def _chosen(self, event: OptionList.OptionSelected) -> None:
        if event.option.id != _NEW:
            self.dismiss(event.option.id)
            return
        from sar_tui.app.screens.new_participant import NewParticipantScreen

        def added(code: str | None) -> None:
            if code:
                self.dismiss(code)

        self.app.push_screen(NewParticipantScreen(), added)

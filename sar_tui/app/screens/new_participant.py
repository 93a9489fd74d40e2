"""Asks for a participant's code, and for the second participant of a task for two."""

from typing import Any, ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Static
from textual.widgets.option_list import Option

from sar_tui.model.language import in_language
from sar_tui.store import participants
from sar_tui.store.database import StoreError
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.widgets.lists import OptionList


class NewParticipantScreen(DismissedOnce[str | None], ModalScreen[str | None]):
    """Asks for a new code; its result is the code, or None."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss(None)", "Cancel", id="cancel")
    ]

    app: Any

    def compose(self) -> ComposeResult:
        tr = self.app.tr
        with Vertical(id="new-participant"):
            yield Static(tr("New participant"), classes="headline")
            yield Static(tr("A code, such as P01. Never a name."), markup=False)
            yield Input(placeholder="P01", max_length=32, id="code")
            yield Static("", id="problem", markup=False)
            yield Static(tr("Press Enter to add, Esc to cancel."), classes="muted")

    @on(Input.Changed)
    def _check(self, event: Input.Changed) -> None:
        self._is_valid(event.value)

    def _is_valid(self, code: str) -> bool:
        problem = ""
        try:
            if participants.check_own(code) in participants.codes(self.app.database):
                problem = self.app.tr("This code is taken.")
        except StoreError as error:
            problem = in_language(error, self.app.tr) if code.strip() else ""
        self.query_one("#problem", Static).update(problem)
        return bool(code.strip()) and not problem

    @on(Input.Submitted)
    def _add(self, event: Input.Submitted) -> None:
        if not event.value.strip():
            self.query_one("#problem", Static).update(self.app.tr("Type a code first."))
            return
        if not self._is_valid(event.value):
            return
        try:
            code = participants.add(self.app.database, event.value)
        except StoreError as error:
            self.query_one("#problem", Static).update(in_language(error, self.app.tr))
        else:
            self.dismiss(code)


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
        tr = self.app.tr
        with Vertical(id="second-participant"):
            yield Static(tr("Who sits on the right?"), classes="headline")
            yield Static(tr("{who} sits on the left.", who=self._first), markup=False)
            yield OptionList(id="others", markup=False)
            yield Static(tr("Arrows and Enter to choose, Esc to cancel."), classes="muted")

    def on_mount(self) -> None:
        self._list()

    def _list(self) -> None:
        others = self.query_one("#others", OptionList)
        others.clear_options()
        codes = [code for code in participants.codes(self.app.database) if code != self._first]
        others.add_options([Option(code, id=code) for code in codes])
        others.add_option(Option(self.app.tr("+ New participant"), id=_NEW))
        others.highlighted = 0

    @on(OptionList.OptionSelected)
    def _chosen(self, event: OptionList.OptionSelected) -> None:
        if event.option.id != _NEW:
            self.dismiss(event.option.id)
            return

        def added(code: str | None) -> None:
            if code:
                self.dismiss(code)

        self.app.push_screen(NewParticipantScreen(), added)

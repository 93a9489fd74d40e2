"""Asks for a participant's code."""

from typing import Any, ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Static

from sar_tui.store import participants
from sar_tui.store.database import StoreError
from sar_tui.tui.dismissed_once import DismissedOnce


class NewParticipantScreen(DismissedOnce[str | None], ModalScreen[str | None]):
    """Asks for a new code; its result is the code, or None."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss(None)", "Cancel", id="cancel")
    ]

    app: Any

    def compose(self) -> ComposeResult:
        with Vertical(id="new-participant"):
            yield Static("New participant", classes="headline")
            yield Static("A code, such as P01. Never a name.", markup=False)
            yield Input(placeholder="P01", max_length=32, id="code")
            yield Static("", id="problem", markup=False)
            yield Static("Press Enter to add, Esc to cancel.", classes="muted")

    @on(Input.Changed)
    def _check(self, event: Input.Changed) -> None:
        self._is_valid(event.value)

    def _is_valid(self, code: str) -> bool:
        problem = ""
        try:
            if participants.check_own(code) in participants.codes(self.app.database):
                problem = "This code is taken."
        except StoreError as error:
            problem = str(error) if code.strip() else ""
        self.query_one("#problem", Static).update(problem)
        return bool(code.strip()) and not problem

    @on(Input.Submitted)
    def _add(self, event: Input.Submitted) -> None:
        if not self._is_valid(event.value):
            return
        try:
            code = participants.add(self.app.database, event.value)
        except StoreError as error:
            self.query_one("#problem", Static).update(str(error))
        else:
            self.dismiss(code)

"""Records an adverse event that began in a session."""

from typing import Any, ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Static

from sar_tui.drivers.login_name import login_name
from sar_tui.store import adverse_events, participants, sessions
from sar_tui.store.database import StoreError
from sar_tui.tui.dismissed_once import DismissedOnce

_FIELDS = {
    "participant": "Participant",
    "onset": "Onset",
    "what": "What happened",
    "severity": "Severity",
    "action": "Action",
    "outcome": "Outcome",
}
_HINTS = {
    "severity": "mild, moderate or severe",
    "action": "what was done; may be added later",
    "outcome": "how it ended; may be added later",
}


class AdverseEventScreen(DismissedOnce[bool], ModalScreen[bool]):
    """A short form; the result is True if the event was recorded.

    Args:
        session: the session, as `store.sessions.listing` returns it. Of two participants, one is named.
    """

    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape", "dismiss(False)", "Cancel", id="cancel")]

    app: Any

    def __init__(self, session: sessions.Row) -> None:
        super().__init__()
        self._session = session

    def compose(self) -> ComposeResult:
        known = {"participant": self._session["participant"], "onset": sessions.local_time(self._session["started_at"])}
        with Vertical(id="adverse-event"):
            yield Static("Adverse event", classes="headline")
            yield Static("", id="problem", markup=False)
            for name, title in _FIELDS.items():
                field = Input(known.get(name, ""), placeholder=_HINTS.get(name, ""), id=name, compact=True)
                field.border_title = title
                field.display = name != "participant" or bool(self._session["partner"])
                yield field
            yield Static("Enter goes on, and records after the last field. Esc: cancel.", classes="muted")

    def on_mount(self) -> None:
        self.query_one("#what").focus()

    @on(Input.Submitted)
    def _entered(self, event: Input.Submitted) -> None:
        event.stop()
        if event.input.id != "outcome":
            self.focus_next()
            return
        given = {name: self.query_one(f"#{name}", Input).value for name in _FIELDS}
        try:
            code = participants.check_code(given.pop("participant"))
            if code not in (self._session["participant"], self._session["partner"]):
                raise StoreError(f"{code} did not take part in this session.")
            adverse_events.report(self.app.database, code, session=self._session["id"], author=login_name(), **given)
        except StoreError as error:
            self.query_one("#problem", Static).update(str(error))
            self.query_one("#adverse-event").scroll_home(animate=False)
        else:
            self.dismiss(True)

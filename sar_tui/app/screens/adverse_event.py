"""Records an adverse event, or what is known of it later."""

from collections.abc import Sequence
from typing import Any, ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Static

from sar_tui.drivers.login_name import login_name
from sar_tui.store import adverse_events, participants
from sar_tui.store.adverse_events import AdverseEvent
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
    """A short form; the result is True if something was recorded.

    Args:
        codes: the participants; of several, one is named.
        onset: when it began, to begin with.
        session: the one in which it began. Without, it is the one under way at the onset, if there
            was any.
        event: to be amended; None for a new one.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss(False)", "Cancel", id="cancel"),
        Binding("down", "app.focus_next", "Next", show=False, id="down"),
        Binding("up", "app.focus_previous", "Previous", show=False, id="up"),
    ]

    app: Any

    def __init__(
        self,
        codes: Sequence[str],
        onset: str = "",
        session: str | None = None,
        event: AdverseEvent | None = None,
    ) -> None:
        super().__init__()
        self._codes = codes
        self._session = session
        self._event = event
        known = {} if event is None else {name: getattr(event, name) for name in _FIELDS}
        self._known = {"participant": codes[0], "onset": onset, **known}

    def compose(self) -> ComposeResult:
        with Vertical(id="adverse-event", classes="form"):
            headline = (
                "Adverse event" if self._event is None else "Adverse event: what is known now"
            )
            yield Static(headline, classes="headline")
            yield Static("", id="problem", markup=False)
            for name, title in _FIELDS.items():
                field = Input(
                    self._known.get(name, ""),
                    placeholder=_HINTS.get(name, ""),
                    id=name,
                    compact=True,
                )
                field.border_title = title
                field.display = name != "participant" or len(self._codes) > 1
                yield field
            yield Static(
                "Enter goes on, and records after the last field. Esc: cancel.", classes="muted"
            )

    def on_mount(self) -> None:
        self.query_one("#what" if self._event is None else "#outcome").focus()

    @on(Input.Submitted)
    def _entered(self, event: Input.Submitted) -> None:
        event.stop()
        if event.input.id != "outcome":
            self.focus_next()
            return
        given: dict[str, Any] = {name: self.query_one(f"#{name}", Input).value for name in _FIELDS}
        try:
            self._save(participants.check_code(given.pop("participant")), given)
        except StoreError as error:
            self.query_one("#problem", Static).update(str(error))
            self.query_one("#adverse-event").scroll_home(animate=False)
        else:
            self.dismiss(True)

    def _save(self, code: str, given: dict[str, Any]) -> None:
        database = self.app.database
        if self._event:
            adverse_events.amend(database, self._event.event, login_name(), **given)
            return
        if code not in self._codes:
            raise StoreError(f"{code} did not take part in this session.")
        session = self._session or adverse_events.session_at(database, code, given["onset"])
        adverse_events.report(database, code, session=session, author=login_name(), **given)

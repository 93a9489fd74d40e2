"""The sessions of a participant, or of everyone, as results. One can be dismissed, or restored."""

from datetime import date
from typing import TYPE_CHECKING, Any, ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.events import Resize
from textual.widgets import Static
from textual.widgets.option_list import Option

from sar_tui.drivers.login_name import login_name
from sar_tui.store.database import StoreError
from sar_tui.widgets.marked_list import MarkedList
from sar_tui.widgets.option_list import OptionList

if TYPE_CHECKING:
    from sar_tui.app.home.contents import Listed
    from sar_tui.model.messages import RecordChange
    from sar_tui.store.sessions import Row

_BESIDE = 4
"""Columns of a line's padding and the scroll bar."""


class SessionList(Vertical):
    """A table of sessions, newest first."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("delete,backspace", "dismiss_session", "Dismiss", id="dismiss-session"),
        Binding("delete,backspace", "take_back", "Take back", id="take-back"),
    ]

    app: Any

    def __init__(self, id: str) -> None:
        super().__init__(id=id)
        self._who: str | None = None
        self._listed: Listed | None = None

    def compose(self) -> ComposeResult:
        yield Static("", id="columns", markup=False)
        yield MarkedList(id="recent", markup=False)

    def on_mount(self) -> None:
        self.border_title = "Sessions"

    def show(self, participant: str | None) -> None:
        """List the sessions of a participant, or of everyone."""
        from sar_tui.app.home.contents import read_sessions

        chosen = self._recent.chosen if participant == self._who else None
        self._who = participant
        self._listed = read_sessions(
            self.app.database, self.app.folder, self.app.catalogue, participant
        )
        self.border_title = f"Sessions of {participant}" if participant else "Sessions of everyone"
        self.border_subtitle = "Enter opens" if self._listed.rows else ""
        self._draw(chosen)

    @property
    def _recent(self) -> MarkedList:
        return self.query_one("#recent", MarkedList)

    @property
    def offered(self) -> "Row | None":
        """The interrupted session that is offered."""
        return self._listed.offered if self._listed else None

    @property
    def offer(self) -> "tuple[date, int, object] | None":
        """Day, attempts done and attempts planned of the session that is offered."""
        if not self._listed or not self._listed.offered:
            return None
        line = self._listed.lines[self._listed.rows.index(self._listed.offered)]
        return (
            line.day,
            self._listed.offered["attempts"],
            self._listed.offered["parameters"].get("attempts", "?"),
        )

    @property
    def chosen(self) -> "Row | None":
        """The chosen session."""
        name = self._recent.chosen
        return (
            next((row for row in self._listed.rows if row["id"] == name), None)
            if self._listed
            else None
        )

    def choose_offered(self) -> None:
        """Choose the session that is offered, if there is one."""
        if self.offered:
            self._recent.choose(self.offered["id"])

    def _draw(self, chosen: str | None) -> None:
        from sar_tui.app.home.session_table import Table

        if self._listed is None:
            return
        rows, lines = self._listed.rows, self._listed.lines
        today = self.app.today()
        table = Table(lines, max(20, self.size.width - _BESIDE), today, names_who=self._who is None)
        self.query_one("#columns", Static).update(table.heading if rows else "")
        recent = self._recent
        recent.clear_options()
        if rows:
            recent.add_options(
                [
                    Option(table.draw(line), id=row["id"])
                    for row, line in zip(rows, lines, strict=True)
                ]
            )
            recent.choose(chosen)
        else:
            recent.add_option(Option("None yet.", disabled=True))
        self.refresh_bindings()

    def on_resize(self, event: Resize) -> None:
        """Fit the lines into another width."""
        self._draw(self._recent.chosen)

    # --- dismissing

    def on_option_list_option_highlighted(self, event: OptionList.OptionHighlighted) -> None:
        """Show the key that dismisses the chosen session, if it is interrupted."""
        self.refresh_bindings()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        from sar_tui.app.home.contents import can_resume

        row = self.chosen
        if action == "dismiss_session":
            return row is not None and can_resume(row)
        if action == "take_back":
            return (
                row is not None and row["status"] in ("dismissed", "discarded") and not row["site"]
            )
        return super().check_action(action, parameters)

    def action_dismiss_session(self) -> None:
        """Dismiss the chosen session, which nobody goes on with."""
        self._change("dismissed")

    def action_take_back(self) -> None:
        """Let the chosen session be resumed again, or count again."""
        self._change("restored")

    def _change(self, change: "RecordChange") -> None:
        from sar_tui.store.record_changes import change_status

        try:
            chosen = self._recent.chosen or ""
            change_status(self.app.database, self.app.folder, chosen, change, actor=login_name())
        except StoreError as error:
            self.notify(str(error), severity="error", timeout=15)
        self.screen.refresh_contents()  # type: ignore[attr-defined]

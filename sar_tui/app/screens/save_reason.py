"""Asks why a programme changes, and who changes it."""

from collections.abc import Sequence
from typing import ClassVar, NamedTuple

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Static

from sar_tui.model.language import Language
from sar_tui.store.programmes import LONGEST_TEXT
from sar_tui.tui.dismissed_once import DismissedOnce

_LINES = 8
"""Largest number of changes that are listed."""


class Reason(NamedTuple):
    """Why a programme changes, and who changes it."""

    reason: str
    author: str


class SaveReasonScreen(DismissedOnce[Reason | None], ModalScreen[Reason | None]):
    """Lists the changes, and asks for a reason; its result is None if nothing is to be saved.

    Args:
        changes: in words.
        author: the name to begin with.
        warning: shown first; empty for none.
        tr: the language of the changes.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss(None)", "Cancel", id="cancel"),
        Binding("down", "app.focus_next", "Next", show=False, id="down"),
        Binding("up", "app.focus_previous", "Previous", show=False, id="up"),
    ]

    def __init__(self, changes: Sequence[str], author: str, warning: str, tr: Language) -> None:
        super().__init__()
        self.tr = tr
        self._changes = changes
        self._author = author
        self._warning = warning

    def compose(self) -> ComposeResult:
        tr = self.tr
        listed = [f"● {change}" for change in self._changes[:_LINES]]
        if (more := len(self._changes) - _LINES) > 0:
            listed.append("  " + tr("and {count} more", count=more))
        with Vertical(classes="dialog"):
            yield Static(tr("Why this change?"), classes="headline")
            if self._warning:
                yield Static(self._warning, id="warning", markup=False)
            yield Static("\n".join(listed), id="changes", markup=False)
            yield Input(
                placeholder=tr("such as: reached the goal four times"),
                max_length=LONGEST_TEXT,
                id="reason",
            )
            yield Static(tr("Your name or initials:"), markup=False)
            yield Input(self._author, max_length=80, id="author", compact=True)
            yield Static("", id="problem", markup=False)
            yield Static(tr("Enter saves, Esc goes back to the settings."), classes="muted")

    @on(Input.Submitted)
    def _save(self) -> None:
        reason = self.query_one("#reason", Input).value.strip()
        if not reason:
            self.query_one("#problem", Static).update(self.tr("A few words are enough."))
            self.query_one("#reason", Input).focus()
            return
        self.dismiss(Reason(reason, self.query_one("#author", Input).value.strip()))

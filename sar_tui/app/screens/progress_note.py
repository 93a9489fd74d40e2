"""A paragraph on a participant's progress, to paste into a record."""

from collections.abc import Callable
from typing import Any, ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical, VerticalScroll
from textual.screen import ModalScreen
from textual.widgets import Static

from sar_tui.tui.dismissed_once import DismissedOnce

_LANGUAGES = {"en": "English", "es": "Spanish"}


class ProgressNoteScreen(DismissedOnce[None], ModalScreen[None]):
    """Shows the paragraph in a language, and puts it into the clipboard of terminals that allow it
    (OSC 52).

    Args:
        text: returns the paragraph in a language, given its code.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("tab,l", "language", "Language", id="language"),
        Binding("escape,enter", "dismiss", "Close", id="close"),
    ]

    app: Any

    def __init__(self, text: Callable[[str], str]) -> None:
        super().__init__()
        self._text = text
        self._language = "en"

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog", id="progress-note"):
            yield Static("", classes="headline", id="headline")
            with VerticalScroll(can_focus=True):
                yield Static("", id="paragraph", markup=False)
            yield Static(
                "It is in the clipboard now, if your terminal allows that. If not, select it with "
                "the mouse (often "
                "with Shift), or use `sar-tui progress CODE --note`.\n\n"
                "Tab: the other language. Up and Down scroll. Esc closes.",
                classes="muted",
                markup=False,
            )

    def on_mount(self) -> None:
        self._show()

    def _show(self) -> None:
        text = self._text(self._language)
        self.query_one("#headline", Static).update(f"Note in {_LANGUAGES[self._language]}")
        self.query_one("#paragraph", Static).update(text)
        self.app.copy_to_clipboard(text)

    def action_language(self) -> None:
        """Show the note in the next language."""
        codes = list(_LANGUAGES)
        self._language = codes[(codes.index(self._language) + 1) % len(codes)]
        self._show()

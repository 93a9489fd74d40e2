"""The screen while the last messages of a session are written, shown if that takes long."""

from textual.app import ComposeResult
from textual.screen import ModalScreen
from textual.widgets import Static

from sar_tui.widgets.language import language_of


class SavingScreen(ModalScreen[None]):
    """Covers the session until the app ends. No key does anything."""

    def compose(self) -> ComposeResult:
        tr = language_of(self.app)
        yield Static(
            f"{tr('One moment…')}\n\n{tr('Your results are being saved.')}",
            id="saving",
            markup=False,
        )

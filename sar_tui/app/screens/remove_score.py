"""Question before a score of another instrument is removed."""

from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Static

from sar_tui.progress.instruments import Score
from sar_tui.tui.dismissed_once import DismissedOnce


class RemoveScoreScreen(DismissedOnce[bool], ModalScreen[bool]):
    """Asks whether a score was entered by mistake; the result is True to remove it."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("enter", "dismiss(True)", "Remove", id="remove"),
        Binding("escape", "dismiss(False)", "Keep", id="keep"),
    ]

    def __init__(self, score: Score) -> None:
        super().__init__()
        self._score = score

    def compose(self) -> ComposeResult:
        score = self._score
        with Vertical(classes="dialog"):
            yield Static("Entered by mistake?", classes="headline")
            yield Static(
                f"{score.instrument} {score.score:g} of {score.date} then no longer counts. The "
                "database keeps it, "
                "with your login name and the time.\n",
                markup=False,
            )
            yield Static("Enter removes it, Esc keeps it.", classes="muted")

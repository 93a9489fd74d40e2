"""The app in which the reaches of one recording are corrected by hand."""

from typing import ClassVar

from textual import events
from textual.binding import Binding, BindingType

from sar_tui.app.correction.screen import CorrectionScreen, Save
from sar_tui.app.screen_keys import HelpScreen
from sar_tui.model.language import Language
from sar_tui.model.theme import Theme
from sar_tui.motion.labels import Correction
from sar_tui.tui.base_app import DESIGN, BaseApp
from sar_tui.tui.too_small import TooSmallScreen, cover_if_too_small
from sar_tui.widgets.speed_chart import Speed


class CorrectionApp(BaseApp):
    """Shows one reach after another, with the keys to correct it.

    Args:
        theme: its colours.
        tr: its language.
        name: of the recording, to show.
        speed: of the recording.
        correction: the labels.
        save: stores them; called after each correction.
    """

    CSS_PATH = [DESIGN, "correction.tcss"]
    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("f1,question_mark", "help", "Help", key_display="F1", id="help"),
        Binding("ctrl+q", "quit", "Quit", show=False, priority=True, id="quit"),
    ]

    def __init__(
        self,
        theme: Theme,
        tr: Language,
        name: str,
        speed: Speed,
        correction: Correction,
        save: Save,
    ) -> None:
        self.tr = tr
        super().__init__()
        self.apply_theme(theme)
        self._screen = CorrectionScreen(name, speed, correction, save)

    def on_mount(self) -> None:
        self.push_screen(self._screen)
        cover_if_too_small(self, self.size)

    def on_resize(self, event: events.Resize) -> None:
        cover_if_too_small(self, event.size)

    def action_help(self) -> None:
        """Explain the screen."""
        if not isinstance(self.screen, (HelpScreen, TooSmallScreen)):
            self.push_screen(HelpScreen(self.screen))

    async def action_quit(self) -> None:
        """Ctrl-Q: leave, also from a dialog; ask first if something could not be saved."""
        self._screen.action_leave()

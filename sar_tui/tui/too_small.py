"""A screen that covers the app while the terminal is too small."""

from typing import Any

from textual import events
from textual.app import App, ComposeResult
from textual.geometry import Size
from textual.screen import Screen
from textual.widgets import Static

from sar_tui.model.spoken_text import sentences
from sar_tui.widgets.language import language_of

MINIMUM = Size(80, 24)


def is_too_small(size: Size) -> bool:
    """True if the screens do not fit. A size of 0 is not known yet."""
    return 0 < size.width < MINIMUM.width or 0 < size.height < MINIMUM.height


def cover_if_too_small(app: App[Any], size: Size) -> None:
    """Cover the app's screen while it does not fit, and uncover it again.

    A cover with another screen on top of it, such as the help, uncovers by itself when that one is
    closed.
    """
    if not is_too_small(size):
        if isinstance(app.screen, TooSmallScreen):
            app.pop_screen()
    elif not any(isinstance(screen, TooSmallScreen) for screen in app.screen_stack):
        app.push_screen(TooSmallScreen())


class TooSmallScreen(Screen[None]):
    """Asks for a larger window; a session below it is paused."""

    def compose(self) -> ComposeResult:
        yield Static(id="too-small", markup=False)

    def on_screen_resume(self) -> None:
        """Uncover if the window grew while another screen was on top of this one."""
        if self.is_active and not is_too_small(self.app.size):
            self.dismiss()

    def on_resize(self, event: events.Resize) -> None:
        self.query_one("#too-small", Static).update(self._text(event.size))

    @property
    def sentences(self) -> list[str]:
        """The wish for a larger window in sentences."""
        return sentences(self._text(self.app.size))

    def _text(self, size: Size) -> str:
        tr = language_of(self.app)
        has = tr("It has {columns} by {rows} characters;", columns=size.width, rows=size.height)
        wish = f"{tr('This window is too small.')}\n\n{tr('Please make it larger.')}"
        needed = tr("{columns} by {rows} are needed.", columns=MINIMUM.width, rows=MINIMUM.height)
        return f"{wish}\n\n{has}\n{needed}"

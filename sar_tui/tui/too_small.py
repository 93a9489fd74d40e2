"""Says that the terminal is too small, until it is not."""

from textual import events
from textual.app import ComposeResult
from textual.geometry import Size
from textual.screen import Screen
from textual.widgets import Static

from sar_tui.widgets.language import language_of

MINIMUM = Size(80, 24)


def is_too_small(size: Size) -> bool:
    """Whether the screens do not fit. A size of 0 is not known yet."""
    return 0 < size.width < MINIMUM.width or 0 < size.height < MINIMUM.height


class TooSmallScreen(Screen[None]):
    """Stands over whatever was there; a session beneath it is paused."""

    def compose(self) -> ComposeResult:
        yield Static(id="too-small", markup=False)

    def on_screen_resume(self) -> None:
        """What stood over this screen is gone; the window may have grown meanwhile."""
        if self.is_current and not is_too_small(self.app.size):
            self.dismiss()

    def on_resize(self, event: events.Resize) -> None:
        tr, size = language_of(self.app), event.size
        has = tr("It has {columns} by {rows} characters;", columns=size.width, rows=size.height)
        needed = tr("{columns} by {rows} are needed.", columns=MINIMUM.width, rows=MINIMUM.height)
        self.query_one("#too-small", Static).update(
            f"{tr('This window is too small.')}\n\n{tr('Please make it larger.')}\n\n{has}\n{needed}"
        )

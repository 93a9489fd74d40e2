"""Says that the terminal is too small, until it is not."""

from textual import events
from textual.app import ComposeResult
from textual.geometry import Size
from textual.screen import Screen
from textual.widgets import Static

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
        size = event.size
        self.query_one("#too-small", Static).update(
            f"This window is too small.\n\nPlease make it larger.\n\n"
            f"It has {size.width} by {size.height} characters;\n{MINIMUM.width} by {MINIMUM.height} are needed."
        )

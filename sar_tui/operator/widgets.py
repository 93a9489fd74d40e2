"""Small widgets of the panel."""

from textual.content import Content
from textual.geometry import Size
from textual.widgets import Input, Static

from sar_tui.tui.too_small import MINIMUM, is_too_small


class CachedStatic(Static):
    """Static text that is redrawn only when it changes.

    Args:
        id: the widget's id.
        fits_content: lay out the screen again when the text changes, because its width follows the
            text.
    """

    def __init__(self, id: str, *, fits_content: bool = False) -> None:
        super().__init__("", id=id, markup=False)
        self._fits_content = fits_content
        self._shown: tuple[object, ...] = ()

    def show(self, content: Content) -> None:
        """Draw the content if it differs from what is shown."""
        key = (content.plain, tuple(content.spans))
        if key != self._shown:
            self._shown = key
            self.update(content, layout=self._fits_content)


class TypedInput(Input):
    """Text field that the panel types into, so that keys keep their order (see `base_app.in_order`)."""

    def put(self, text: str) -> None:
        """Insert text at the cursor, replacing the selection."""
        self.replace(text, *self.selection)


class TooSmallNotice(Static):
    """Notice that covers the panel while its window is too small.

    Args:
        stop_key: label of the key that stops the agent, which keeps working.
    """

    def __init__(self, stop_key: str) -> None:
        super().__init__("", id="too-small", markup=False)
        self._stop_key = stop_key

    def fit(self, size: Size) -> None:
        """Show or hide the notice for a window of this size."""
        self.display = is_too_small(size)
        self.update(
            f"This window is too small: it has {size.width} by {size.height} characters, and "
            f"{MINIMUM.width} by {MINIMUM.height} are needed.\n\nPlease make it larger. "
            f"Until then only {self._stop_key} (stop the agent) works. The session goes on."
        )

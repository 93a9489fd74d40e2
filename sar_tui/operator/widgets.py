"""Small widgets of the panel."""

from textual.content import Content
from textual.geometry import Size
from textual.widgets import Input, Static

from sar_tui.model.language import Language
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
        tr: language of the panel.
    """

    def __init__(self, stop_key: str, tr: Language) -> None:
        super().__init__("", id="too-small", markup=False)
        self._stop_key, self._tr = stop_key, tr

    def fit(self, size: Size) -> None:
        """Show or hide the notice for a window of this size."""
        tr = self._tr
        self.display = is_too_small(size)
        problem = tr(
            "This window is too small: it has {width} by {height} characters, and {least_width} by "
            "{least_height} are needed.",
            width=size.width,
            height=size.height,
            least_width=MINIMUM.width,
            least_height=MINIMUM.height,
        )
        advice = tr(
            "Please make it larger. Until then only {key} (stop the agent) works. The session goes "
            "on.",
            key=self._stop_key,
        )
        self.update(f"{problem}\n\n{advice}")

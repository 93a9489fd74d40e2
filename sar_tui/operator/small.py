"""What lies over the panel while its window is too small for it."""

from textual.geometry import Size
from textual.widgets import Static

from sar_tui.tui.too_small import MINIMUM, is_too_small


class Small(Static):
    """Says so, and which key works all the same.

    Args:
        stop_key: of the agent, as it is called.
    """

    def __init__(self, stop_key: str) -> None:
        super().__init__("", id="small", markup=False)
        self._stop_key = stop_key

    def fit(self, size: Size) -> None:
        """The window has another size."""
        self.display = is_too_small(size)
        self.update(
            f"This window is too small: it has {size.width} by {size.height} characters, and "
            f"{MINIMUM.width} by {MINIMUM.height} are needed.\n\nPlease make it larger. "
            f"Until then only {self._stop_key} (stop the agent) works. The session goes on."
        )

"""The one thing to do on a screen: a sentence with its key, always in the row above the footer."""

from textual.content import Content
from textual.geometry import Size
from textual.widget import Widget

from sar_tui.tui.heading import is_roomy

_GAP = "\N{NO-BREAK SPACE}"


class KeyLine(Widget):
    """Shows a sentence in which the name of the key looks like a key. It changes only by ``show``,
    and with the window's size.

    Args:
        text: the sentence; empty: nothing is to be done.
        keys: names of keys; the first that stands in the sentence is shown as a key.
        grows: in a large window the key is a cap of three rows, for participants.
    """

    def __init__(
        self, text: str = "", *keys: str, grows: bool = False, id: str | None = None
    ) -> None:
        super().__init__(id=id)
        self._grows = grows
        self.show(text, *keys)

    def show(self, text: str, *keys: str) -> None:
        """Show what to do."""
        self.text = text
        self._key = next((key for key in keys if key in text), "")
        self.refresh(layout=True)

    @property
    def _is_large(self) -> bool:
        return self._grows and bool(self._key) and is_roomy(*self.app.size)

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:
        return 3 if self._is_large else 1

    def render(self) -> Content:
        if not self._key:
            return Content(self.text)
        before, found, after = self.text.partition(self._key)
        if not self._is_large:
            # the spaces beside the name become part of the key
            cap = f"{' ' * before.endswith(' ')}{found}{' ' * after.startswith(' ')}"
            words = before.removesuffix(" "), after.removeprefix(" ")
            return Content.assemble(words[0], (cap, "$background on $accent"), words[1])
        edge = "─" * (len(found) + 2)
        left, right = _GAP * len(before), _GAP * len(after)  # keep the cap where it is centred
        rows = (
            (left, f"╭{edge}╮", right),
            (before, f"│ {found} │", after),
            (left, f"╰{edge}╯", right),
        )
        return Content("\n").join(
            Content.assemble(text, (cap, "$accent"), more) for text, cap, more in rows
        )

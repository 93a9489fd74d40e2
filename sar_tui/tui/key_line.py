"""The one thing to do on a screen: a sentence with its key, always in the row above the footer."""

from collections.abc import Sequence

from textual.content import Content
from textual.geometry import Size
from textual.widget import Widget

from sar_tui.tui.heading import is_roomy

_GAP = "\N{NO-BREAK SPACE}"
_BETWEEN = "   "
_MARK = "▸ "


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
        self._marked: tuple[str, str, str] | None = None
        self._spoken = ""
        self.show(text, *keys)

    def show(self, text: str, *keys: str) -> None:
        """Show what to do."""
        self._text = text
        self._key = next((key for key in keys if key in text), "")
        self.refresh(layout=True)

    def mark(self, text: str, labels: Sequence[str] = (), at: int = 0) -> None:
        """Show choices in place of the key, one of them marked, until `unmark`; only that one where
        there is no room for all.

        Args:
            text: the sentence before them.
            labels: their words.
            at: place of the marked one.
        """
        if sum(map(len, labels)) + len(labels) * len(_BETWEEN) + len(text) > self.app.size.width:
            labels, at = labels[at : at + 1], 0
        self._spoken = "\n".join((text, *labels[at : at + 1]))
        before = (f"{text} ", *labels[:at])
        cap = f"{_MARK}{labels[at]}" if labels else ""
        self._marked = (
            _BETWEEN.join(before),
            cap,
            "".join(f"{_BETWEEN}{one}" for one in labels[at + 1 :]),
        )
        self.refresh(layout=True)

    @property
    def text(self) -> str:
        """The sentence; of choices the one that is marked."""
        return self._spoken if self._marked else self._text

    def unmark(self) -> None:
        """Show the sentence again."""
        if self._marked:
            self._marked = None
            self.refresh(layout=True)

    @property
    def _parts(self) -> tuple[str, str, str]:
        """Words before the key, the key (empty if there is none), words after it."""
        if self._marked:
            return self._marked
        return self._text.partition(self._key) if self._key else (self._text, "", "")

    @property
    def _is_large(self) -> bool:
        return self._grows and bool(self._parts[1]) and is_roomy(*self.app.size)

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:
        if self._is_large:
            return 3
        return max(1, self.render().get_height({}, max(1, width)))

    def render(self) -> Content:
        before, found, after = self._parts
        if not found:
            return Content(before)
        if not self._is_large:
            return Content.assemble(before, (found, "$background on $accent"), after)
        cap = f"{_GAP * 2}{found}{_GAP * 2}"
        left, right = _GAP * len(before), _GAP * len(after)  # keep the cap where it is centred
        rows = (
            (left, "▄" * len(cap), "$accent", right),
            (before, cap, "$background on $accent", after),
            (left, "▀" * len(cap), "$accent", right),
        )
        return Content("\n").join(
            Content.assemble(text, (drawn, style), more) for text, drawn, style, more in rows
        )

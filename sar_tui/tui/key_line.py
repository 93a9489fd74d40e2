"""The one thing to do on a screen: a sentence with its key, always in the row above the footer."""

from textual.content import Content
from textual.widget import Widget


class KeyLine(Widget):
    """Shows a sentence in which the name of the key looks like a key. It changes only by
    ``show``.
    """

    def __init__(self, text: str = "", key: str = "", id: str | None = None) -> None:
        super().__init__(id=id)
        self._text, self._key = text, key

    def show(self, text: str, key: str = "") -> None:
        """Show what to do.

        Args:
            text: the sentence; empty: nothing is to be done.
            key: the name of the key as it stands in the sentence.
        """
        self._text, self._key = text, key
        self.refresh()

    def render(self) -> Content:
        before, found, after = (
            self._text.partition(self._key) if self._key else (self._text, "", "")
        )
        if not found:
            return Content(self._text)
        return Content.assemble(before, (f" {found} ", "$background on $accent bold"), after)

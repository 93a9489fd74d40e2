"""The middle of the session's screen while it waits for somebody: result, words, drawing, and the
key to press.
"""

from typing import NamedTuple

from rich.text import Text
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.widget import Widget
from textual.widgets import Static

from sar_tui.app.screens.waiting_text import WaitingText
from sar_tui.tui.heading import is_roomy
from sar_tui.widgets.goal_bar import GoalBar, draw_bars
from sar_tui.widgets.language import language_of
from sar_tui.widgets.large_characters import bitmap, draw
from sar_tui.widgets.task_view import Drawing

_DRAWING_ROWS, _DRAWING_COLUMNS = 7, 72
"""Least rows of a drawing, with the blank one above it, and most columns."""


class MessagePanel(Vertical):
    """Shows a message, larger in a large window. It changes only by its methods, and with the
    window's size.

    Where there is little room the words stay, then the drawing, then the bars.
    """

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._text = WaitingText("", "", "")
        self._bars: list[GoalBar] = []
        self._ask = ""
        self._drawing: Drawing | None = None

    def compose(self) -> ComposeResult:
        yield Static("", id="result")
        yield Static("", id="headline", markup=False)
        yield Static("", id="text", markup=False)
        yield DrawingArea(id="drawing")
        yield Static("", id="key", markup=False)
        yield Static("", id="enter", markup=False)
        yield Static("", id="ask", markup=False)

    def show(
        self, text: WaitingText, bars: list[GoalBar], drawing: Drawing | None = None, ask: str = ""
    ) -> None:
        """Show a message, below the bars of the last attempt. ``ask``: how to request feedback on
        it, or empty.
        """
        self._text, self._bars, self._ask, self._drawing = text, bars, ask, drawing
        self._arrange()

    def correct(self, later: str) -> None:
        """Add to the key to press that another one comes later."""
        self.query_one("#enter", Static).update(f"{self._text.press} {later}")

    def on_resize(self) -> None:
        self._arrange()

    def _arrange(self) -> None:
        width, height = self.content_size
        left = height - rows_of(self._text, width) - bool(self._ask)
        drawing = self._drawing if left >= _DRAWING_ROWS else None
        has_bars = bool(self._bars) and left >= len(self._bars) + 1 + (
            _DRAWING_ROWS if drawing else 0
        )
        bars = draw_bars(self._bars, width, language_of(self.app)) if has_bars else ""
        area = self.query_one(DrawingArea)
        area.styles.margin = (1, 0, 0, max(0, (width - _DRAWING_COLUMNS) // 2))
        area.show(drawing)
        message = Message(self._text.headline, self._text.text, "", self._text.press)
        if is_roomy(*self.app.size) and not drawing:
            more = (len(self._bars) + 1) * has_bars + bool(self._ask)
            message = large_message(self._text, width, height, more=more)
        self._put("result", bars)
        for name in ("headline", "key"):
            words: str = getattr(message, name)
            is_drawn = "\n" in words
            self.query_one(f"#{name}").set_class(is_drawn, "drawn")
            self._put(name, _centred(words, width) if is_drawn else words)
        self._put("text", message.text)
        self._put("enter", message.press)
        self._put("ask", self._ask)

    def _put(self, name: str, words: object) -> None:
        part = self.query_one(f"#{name}", Static)
        part.display = bool(words)
        part.update(words)  # type: ignore[arg-type]


def _centred(drawn: str, width: int) -> str:
    """Indent large letters, whose lines are equally long."""
    lines = drawn.split("\n")
    indent = " " * max(0, (width - len(lines[0])) // 2)
    return "\n".join(f"{indent}{line}" for line in lines)


_LETTER, _HEIGHT = 8, 4
"""Columns and rows of a large letter, drawn in half blocks."""


class Message(NamedTuple):
    """Parts of a message, from top to bottom. ``key``: the key to press, drawn; empty if its name
    is in ``press``.
    """

    headline: str
    text: str
    key: str
    press: str


def rows_of(text: WaitingText, width: int) -> int:
    """Return the rows of a message as it is written, with the blank ones between its parts."""
    parts = [_rows(part, width) for part in (text.headline, text.text, text.press) if part]
    return sum(parts) + max(0, len(parts) - 1)


def large_message(text: WaitingText, width: int, height: int, *, more: int = 0) -> Message:
    """Return a message for ``width`` by ``height`` cells: with the key drawn large, more air, and a
    large headline of one word.

    Each of these, in this order, only if there is room; the words are never left out.

    Args:
        text: the message.
        width, height: of the part of the screen that is for it.
        more: rows of what else is shown there.
    """
    rows = (
        height
        - more
        - _rows(text.headline, width)
        - _rows(text.text, width)
        - _rows(text.press, width)
        - 4
    )
    key, headline, lines = "", text.headline, text.text
    if drawn := _drawn(text.key, width, rows - 1):
        key, rows = "\n".join(drawn), rows - len(drawn) - 1
    if 0 < (air := text.text.count("\n") - 2 * text.text.count("\n\n")) <= rows:
        lines, rows = "\n\n".join(part for part in text.text.split("\n") if part), rows - air
    if " " not in text.headline and (drawn := _drawn(text.headline, width, rows)):
        headline = "\n".join(drawn)
    return Message(headline, lines, key, text.press)


def _drawn(text: str, width: int, rows: int) -> tuple[str, ...]:
    """Draw a text in large letters, all lines equally long; nothing if there is no room, or no such
    letter.
    """
    if (
        any(not bitmap(letter) for letter in text if letter != " ")
        or len(text) * _LETTER > width
        or rows < _HEIGHT
    ):
        return ()
    drawn = draw(text, width, _HEIGHT) if text else ()
    if len(drawn) != _HEIGHT:
        return ()
    longest = max(map(len, drawn))
    return tuple(line.ljust(longest) for line in drawn)


def _rows(text: str, width: int) -> int:
    return sum(-(-max(1, len(line)) // max(1, width)) for line in text.split("\n")) if text else 0


class DrawingArea(Widget):
    """Shows a drawing, and takes no room without one."""

    DEFAULT_CSS = "DrawingArea { height: 1fr; min-height: 6; display: none; }"

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._drawing: Drawing | None = None

    def show(self, drawing: Drawing | None) -> None:
        """Show a drawing; None for nothing."""
        self._drawing = drawing
        self.display = drawing is not None
        self.refresh()

    def render(self) -> Text:
        width, height = self.content_size
        if not self._drawing or not width or not height:
            return Text("")
        return self._drawing(width, height, self.app.theme_variables)

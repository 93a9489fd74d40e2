"""The middle of the session's screen while it waits for somebody: result, words and drawing."""

from collections.abc import Callable

from rich.text import Text
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from sar_tui.app.screens.waiting_text import WaitingText
from sar_tui.model.results_for_people import result_text
from sar_tui.model.spoken_text import sentences
from sar_tui.tui.base_app import on_linux_console
from sar_tui.tui.heading import ONE_LINE, TALL, TWO_LINES, Heading, figures_in_blocks, is_roomy
from sar_tui.widgets.answer_options import with_chosen
from sar_tui.widgets.block_digits import draw_result
from sar_tui.widgets.goal_bar import GoalBar, draw_bars, rows_of_bars, verdict
from sar_tui.widgets.language import language_of
from sar_tui.widgets.task_view import Drawing

_DRAWING_ROWS, _DRAWING_COLUMNS = 7, 72
"""Least rows of a drawing, with the blank one above it, and most columns."""
_BARS, _LARGE_BARS = 68, 92
"""Most columns of the bars and their words, in a small and in a large window."""
_GAP = 2
"""Blank rows below each part of a result in a tall window."""
_PADDING = 2
"""Rows that the band of the headline takes besides, in a tall window."""


class MessagePanel(Vertical):
    """Shows a message, larger in a large window. It changes only by its methods, and with the
    window's size.

    Where there is little room the words stay, then the drawing, then the bars.

    Args:
        arranged: called when it is drawn: True if the result of a single participant is shown.
    """

    def __init__(self, arranged: Callable[[bool], None], *, id: str | None = None) -> None:
        super().__init__(id=id)
        self._arranged = arranged
        self._text = WaitingText("", "", "")
        self._bars: list[GoalBar] = []
        self._ask = ""
        self._drawing: Drawing | None = None

    def compose(self) -> ComposeResult:
        yield Static("", id="figure", classes="sentence", markup=False)
        yield Heading(id="verdict")
        yield Static("", id="result")
        yield Heading(id="headline")
        yield Static("", id="text", markup=False)
        yield DrawingArea(id="drawing")
        yield Static("", id="ask", markup=False)

    def show(
        self, text: WaitingText, bars: list[GoalBar], drawing: Drawing | None = None, ask: str = ""
    ) -> None:
        """Show a message, below the bars of the last attempt. ``ask``: how to request feedback on
        it, or empty.
        """
        self._text, self._bars, self._ask, self._drawing = text, bars, ask, drawing
        self._arrange()

    @property
    def sentences(self) -> list[str]:
        """The message in sentences, without its drawings."""
        return [*self._text.sentences, *sentences(self._ask)]

    def on_resize(self) -> None:
        self._arrange()

    def _arrange(self) -> None:
        width, height = self.content_size
        left = height - rows_of(self._text, width) - bool(self._ask)
        drawing = self._drawing if left >= _DRAWING_ROWS else None
        left -= _DRAWING_ROWS if drawing else 0
        is_tall = self.app.size.height >= TALL
        padding = _PADDING if self._bars and is_tall else 0
        left -= padding
        is_large = is_roomy(*self.app.size) and not drawing
        # where little is left, a small verdict, thin bars, and then no figure
        bars, rows, verdict_rows = Content(""), 0, 1
        gap = _GAP if is_tall else 1
        drawn = self._figure(width, is_large)
        small = [(False, drawn, 1), (False, [], 1)]
        large = [(True, drawn, ONE_LINE), (True, drawn, 1)] if is_large else []
        for thick, figure, verdict_rows in (*large, *small):
            rows = rows_of_bars(self._bars, is_large=thick) + gap
            rows += (len(figure) + gap) * bool(figure)
            rows += (verdict_rows + gap) * (len(self._bars) == 1)
            if self._bars and rows <= left:
                room = min(width, _LARGE_BARS if is_large else _BARS)
                bars = draw_bars(self._bars, room, language_of(self.app), is_large=thick)
                break
        if not bars:
            figure, rows = [], 0
        area = self.query_one(DrawingArea)
        area.styles.margin = (1, 0, 0, max(0, (width - _DRAWING_COLUMNS) // 2))
        area.show(drawing)
        text, headline_rows = self._text.text, 1
        if is_large:
            rest = height - rows - padding - bool(self._ask)
            text, headline_rows = spread(self._text, width, rest)
        self._put("figure", "\n".join(figure))
        is_alone = bool(bars) and len(self._bars) == 1
        self._judge(self._bars[0] if is_alone else None, verdict_rows)
        self._put("result", bars)
        headline = self.query_one("#headline", Heading)
        headline.set_class(bool(bars), "band")
        side = max(0, (width - _LARGE_BARS) // 2)
        headline.styles.margin = (0, side, 0 if is_tall else 1, side) if bars else None
        headline.show(self._text.headline, 1 if figure else headline_rows)
        self._put("text", with_chosen(text))
        self._put("ask", self._ask)
        self._arranged(is_alone)

    def _judge(self, bar: GoalBar | None, most_rows: int) -> None:
        """Show whether the goal is reached: praise if it is."""
        is_reached = bar is not None and bar.is_reached
        self.query_one("#figure").set_class(is_reached, "well-done")
        shown = self.query_one("#verdict", Heading)
        shown.set_classes("well-done" if is_reached else "body")
        shown.show(
            verdict(bar, language_of(self.app)) if bar else "", most_rows if is_reached else 1
        )

    def _figure(self, width: int, is_large: bool) -> list[str]:
        """Return the rows of the result of the last attempt, if it can be drawn large; none if not,
        or if there are several.
        """
        if len(self._bars) != 1:
            return []
        bar = self._bars[0]
        text = result_text(bar.metric, bar.value, language_of(self.app))
        if is_large and (drawn := figures_in_blocks(text, width)):
            return drawn
        # its font has no half blocks
        return [] if on_linux_console() else draw_result(text)

    def _put(self, name: str, words: object) -> None:
        part = self.query_one(f"#{name}", Static)
        part.display = bool(words)
        part.update(words)  # type: ignore[arg-type]


def rows_of(text: WaitingText, width: int) -> int:
    """Return the rows of a message as it is written, with the blank ones between its parts."""
    parts = [rows_of_text(part, width) for part in (text.headline, text.text) if part]
    return sum(parts) + max(0, len(parts) - 1)


def spread(text: WaitingText, width: int, height: int) -> tuple[str, int]:
    """Return the lines of a message for a large window, with a blank one between them if there is
    room, and the rows that are left for its headline.
    """
    lines = text.text
    left = height - rows_of(text, width)
    if 0 < (air := lines.count("\n") - 2 * lines.count("\n\n")) <= left:
        lines = "\n\n".join(part for part in lines.split("\n") if part)
        left -= air
    return lines, min(TWO_LINES, 1 + max(0, left))


def rows_of_text(text: str, width: int) -> int:
    """Return the rows of a text in lines of so many columns; none of an empty text."""
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

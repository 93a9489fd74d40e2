"""The angular speed of a hand in a window of a long recording, with the reaches in it marked."""

import math
from collections.abc import Callable, Mapping
from itertools import groupby
from typing import Any, ClassVar, NamedTuple

import numpy as np
from rich.style import Style
from rich.text import Text
from textual.widget import Widget

from sar_tui.model.language import ENGLISH, Language
from sar_tui.motion.arrays import lengths
from sar_tui.motion.samples import Floats, Samples
from sar_tui.widgets.language import language_of

PARTS = ("chosen", "other", "edge", "axis")
"""Parts with a style: the curve in the chosen reach, the rest of it, the chosen reach's edges, and
everything else.
"""
Styles = Mapping[str, str | Style]

_MARGIN = 6
_SMALLEST = (20, 4)
_FLATTEST_DEG_S = 20.0
"""Speed up to which the chart goes at least, so that noise at rest looks small."""
_ROOM = 1.05
_HOLE_S = 0.25
"""The curve is left out where samples are missing for longer."""
_DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
_BLANK = 0x2800
_SPEED_STEPS = [m * 10**power for power in range(5) for m in (1, 2, 5)]
_TIME_STEPS = (1, 2, 5, 10, 15, 30, 60, 120, 300, 600)


class Speed(NamedTuple):
    """The speed of a whole recording: ``time_s`` and ``deg_s``, shape (n,) each."""

    time_s: Floats
    deg_s: Floats

    @classmethod
    def of(cls, samples: Samples) -> "Speed":
        """Return the norm of the angular rate of samples, on their own time axis."""
        return cls(samples["at"] / 1e9, np.degrees(lengths(samples["rate"].astype(float))))


class Span(NamedTuple):
    """A stretch of time with a name."""

    from_s: float
    to_s: float
    name: str
    is_chosen: bool = False


class View(NamedTuple):
    """The time between two moments, the reaches in it, and the cursor."""

    from_s: float
    to_s: float
    spans: tuple[Span, ...] = ()
    cursor_s: float | None = None


class SpeedChart(Widget):
    """Shows a part of a recording, and draws nothing else of it.

    Args:
        speed: of the recording.
        clock: returns a time of the recording in words, for the axis.
    """

    COMPONENT_CLASSES: ClassVar[set[str]] = {f"speed-chart--{part}" for part in PARTS}
    DEFAULT_CSS = """
    SpeedChart { height: 1fr; min-height: 6; }
    SpeedChart > .speed-chart--chosen { color: $accent; text-style: bold; }
    SpeedChart > .speed-chart--other { color: $foreground; }
    SpeedChart > .speed-chart--edge { color: $accent; text-style: bold; }
    SpeedChart > .speed-chart--axis { color: $text-muted; }
    """

    def __init__(self, speed: Speed, clock: Callable[[float], str], id: str | None = None) -> None:
        super().__init__(id=id)
        self._speed, self._clock = speed, clock
        self._view: View | None = None

    def show(self, view: View) -> None:
        """Draw a part of the recording."""
        self._view = view
        self.refresh()

    def render(self) -> Text:
        width, height = self.content_size
        if self._view is None or width < _SMALLEST[0] or height < _SMALLEST[1]:
            return Text("")
        styles = {
            part: self.get_component_rich_style(f"speed-chart--{part}", partial=True)
            for part in PARTS
        }
        tr = language_of(self.app)
        return draw_speed(self._speed, self._view, width, height, self._clock, styles, tr)


def draw_speed(
    speed: Speed,
    view: View,
    width: int,
    height: int,
    clock: Callable[[float], str],
    styles: Styles | None = None,
    tr: Language = ENGLISH,
) -> Text:
    """Draw a part of a recording as text: names of reaches in brackets, the curve from zero on, and
    the times.

    Args:
        speed: of the whole recording.
        view: the part.
        width, height: in characters.
        clock: returns the words of a time.
        styles: of the ``PARTS``; the chart can be read without any.
        tr: the language of the figures.
    """
    chart = _Chart(speed, view, width - _MARGIN, height - 2, styles or {}, tr)
    lines = [chart.names(), *chart.body(), chart.times(clock)]
    return Text("\n", no_wrap=True, end="").join(lines)


class _Chart:
    """A chart of ``columns`` by ``rows`` cells of 2 by 4 dots, with its scales."""

    def __init__(
        self, speed: Speed, view: View, columns: int, rows: int, styles: Styles, tr: Language
    ) -> None:
        self._view, self._columns, self._rows = view, columns, rows
        self._styles, self._tr = styles, tr
        self._begins_s = float(speed.time_s[0])
        self._heights = mean_speeds(speed, view.from_s, view.to_s, 2 * columns)
        most = float(np.nanmax(self._heights, initial=0.0))
        self._unit = _ROOM * max(most, _FLATTEST_DEG_S) / (4 * rows - 1)

    def _style(self, part: str) -> str | Style:
        return self._styles.get(part, "")

    def _column(self, time_s: float) -> int:
        view = self._view
        share = (time_s - view.from_s) / (view.to_s - view.from_s)
        return min(self._columns - 1, max(0, int(share * self._columns)))

    def _is_seen(self, time_s: float) -> bool:
        return self._view.from_s <= time_s <= self._view.to_s

    def names(self) -> Text:
        """Return the line of the reaches' names, each in brackets as wide as it lasts."""
        line = Text("°/s".ljust(_MARGIN), self._style("axis"))
        at = 0
        for span in self._view.spans:
            if span.to_s < self._view.from_s or span.from_s > self._view.to_s:
                continue
            first, last = max(at, self._column(span.from_s)), self._column(span.to_s)
            if last < first:
                continue
            line.append(" " * (first - at))
            left = "├" if self._is_seen(span.from_s) else "─"
            right = "┤" if self._is_seen(span.to_s) else "─"
            bracket = _bracket(span.name, last - first + 1, left, right)
            line.append(bracket, self._style("edge" if span.is_chosen else "axis"))
            at = last + 1
        line.append(" " * (self._columns - at))
        return line

    def body(self) -> list[Text]:
        """Return the rows of the curve."""
        cells, labels = self._cells(), self._labels()
        empty, inside = self._marks(), range(0)
        for span in self._view.spans:
            if span.is_chosen:
                inside = range(self._column(span.from_s), self._column(span.to_s) + 1)
        rows = []
        for row in range(self._rows):
            axis = "┤" if row in labels else "│"
            line = Text(labels.get(row, "").rjust(_MARGIN - 1) + axis, self._style("axis"))
            drawn = [
                (chr(_BLANK + dots), "chosen" if column in inside else "other")
                if dots
                else empty.get(column, (" ", "axis"))
                for column, dots in enumerate(cells[row].tolist())
            ]
            for part, run in groupby(drawn, lambda cell: cell[1]):
                line.append("".join(mark for mark, _ in run), self._style(part))
            rows.append(line)
        return rows

    def _marks(self) -> dict[int, tuple[str, str]]:
        """Return what stands beside the curve in columns of edges, and its style."""
        marks = {}
        for span in sorted(self._view.spans, key=lambda span: span.is_chosen):
            mark = ("│", "edge") if span.is_chosen else ("┊", "axis")
            seen = (time_s for time_s in span[:2] if self._is_seen(time_s))
            marks.update(dict.fromkeys(map(self._column, seen), mark))
        return marks

    def times(self, clock: Callable[[float], str]) -> Text:
        """Return the line of times since the beginning of the recording, with the cursor."""
        view, width = self._view, self._columns + _MARGIN
        per_cell = (view.to_s - view.from_s) / self._columns
        step = next((step for step in _TIME_STEPS if step >= 10 * per_cell), _TIME_STEPS[-1])
        cells = [" "] * width
        free, cursor = _MARGIN, -1
        if view.cursor_s is not None and self._is_seen(view.cursor_s):
            cursor = _MARGIN + self._column(view.cursor_s)
        first_number = max(0, math.ceil((view.from_s - self._begins_s) / step))
        for number in range(first_number, math.floor((view.to_s - self._begins_s) / step) + 1):
            time_s = self._begins_s + number * step
            label = clock(time_s)
            first = _MARGIN + self._column(time_s) - len(label) // 2
            is_free = free <= first and not first <= cursor < first + len(label)
            if is_free and first + len(label) <= width:
                cells[first : first + len(label)] = label
                free = first + len(label) + 1
        line = Text("".join(cells), self._style("axis"))
        if cursor >= 0:
            line = Text.assemble(line[:cursor], ("▲", self._style("edge")), line[cursor + 1 :])
        return line

    def _cells(self) -> Any:
        """Return the Braille dots of the curve, shape (rows, columns)."""
        cells = np.zeros((self._rows, self._columns), dtype=np.uint8)
        lowest, before = 4 * self._rows - 1, None
        for column, height in enumerate(self._heights.tolist()):
            if math.isnan(height):
                before = None
                continue
            dot = max(0, lowest - round(height / self._unit))
            last = dot if before is None else before
            from_dot, to_dot = (
                (dot, max(dot, last - 1)) if last > dot else (min(dot, last + 1), dot)
            )
            for y in range(from_dot, to_dot + 1):
                cells[y // 4, column // 2] |= _DOTS[y % 4][column % 2]
            before = dot
        return cells

    def _labels(self) -> dict[int, str]:
        """Return round numbers, by the row they label."""
        step = next(step for step in _SPEED_STEPS if step >= max(8, self._rows // 2) * self._unit)
        labels = {}
        for count in range(self._rows + 1):
            dot = 4 * self._rows - 1 - round(count * step / self._unit)
            if dot >= 0:
                labels[dot // 4] = self._tr.figures(f"{count * step:g}")
        return labels


def mean_speeds(speed: Speed, from_s: float, to_s: float, count: int) -> Floats:
    """Return the mean speeds in equal parts of a time, shape (count,); NaN where samples are
    missing. Only the samples of that time are looked at.
    """
    first, last = np.searchsorted(speed.time_s, (from_s, to_s)).tolist()
    part = slice(max(0, first - 1), last + 1)
    time, values = speed.time_s[part], speed.deg_s[part].astype(float)
    if len(time) < 2:
        return np.full(count, np.nan)
    steps = np.diff(time)
    path = np.concatenate(([0.0], np.cumsum(steps * (values[1:] + values[:-1]) / 2)))
    edges = np.linspace(from_s, to_s, count + 1)
    means = np.diff(np.interp(edges, time, path)) * count / (to_s - from_s)
    middles = (edges[1:] + edges[:-1]) / 2
    at = np.searchsorted(time, middles).clip(1, len(time) - 1)
    is_missing = (steps[at - 1] > _HOLE_S) | (middles < time[0]) | (middles > time[-1])
    found: Floats = np.where(is_missing, np.nan, means)
    return found


def _bracket(name: str, width: int, left: str, right: str) -> str:
    """Return a name in brackets, shortened to fit."""
    if width >= len(name) + 4:
        return left + f" {name} ".center(width - 2, "─") + right
    return (left + "─" * (width - 2) + right)[:width] if width > 1 else "│"

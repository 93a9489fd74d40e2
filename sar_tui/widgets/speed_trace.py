"""Reaches as curves: angular rate of the hand over time."""

import math
from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
import numpy.typing as npt
from rich.style import Style
from rich.text import Text
from textual.widget import Widget

from sar_tui.model.language import ENGLISH, Language
from sar_tui.motion.trace import Trace
from sar_tui.widgets.language import language_of

SMALLEST = (40, 6)
"""Smallest size of a plot, columns and rows."""

PARTS = ("out", "dwell", "back", "rest", "earlier", "axis")
"""Parts of a plot with a style: the newest reach's phases, its rest, earlier reaches, and
everything else.
"""
Styles = Mapping[str, str | Style]

_MARGIN = 6
_LEGEND_FROM = 9
_ROOM = 1.08
_FLATTEST = 0.5
_DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
_BLANK = 0x2800
_STEPS = [round(m * 10.0**power, 3) for power in range(-2, 4) for m in (1, 2, 5)]


class SpeedTrace(Widget):
    """Shows a few reaches, the newest as a full line, earlier ones as dots. It has no timer."""

    COMPONENT_CLASSES: ClassVar[set[str]] = {f"speed-trace--{part}" for part in PARTS}
    DEFAULT_CSS = """
    SpeedTrace { height: 1fr; min-height: 6; }
    SpeedTrace > .speed-trace--out { color: $accent; text-style: bold; }
    SpeedTrace > .speed-trace--dwell { color: $text-muted; text-style: bold; }
    SpeedTrace > .speed-trace--back { color: $foreground; text-style: bold; }
    SpeedTrace > .speed-trace--rest { color: $text-muted; }
    SpeedTrace > .speed-trace--earlier { color: $text-muted; }
    SpeedTrace > .speed-trace--axis { color: $text-muted; }
    """

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._traces: tuple[Trace, ...] = ()

    def show(self, traces: Sequence[Trace]) -> None:
        """Draw these reaches, the newest last; none, to clear."""
        self._traces = tuple(traces)
        self.refresh()

    def render(self) -> Text:
        width, height = self.content_size
        if not self._traces or not width or not height:
            return Text("")
        styles = {
            part: self.get_component_rich_style(f"speed-trace--{part}", partial=True)
            for part in PARTS
        }
        return draw_traces(self._traces, width, height, styles, language_of(self.app))


def draw_traces(
    traces: Sequence[Trace],
    width: int,
    height: int,
    styles: Styles | None = None,
    tr: Language = ENGLISH,
) -> Text:
    """Draw reaches as text, all beginning at 0 s: names of the newest one's phases, curves, zero
    line, time axis.

    Args:
        traces: the newest last, at least one.
        width, height: in characters, at least 40 by 6; from 9 rows on, several reaches have a
            legend.
        styles: of the ``PARTS``; the plot can be read without any.
        tr: the language of the phases' names and of the figures.
    """
    width, height = max(width, SMALLEST[0]), max(height, SMALLEST[1])
    styles = styles or {}
    has_legend = height >= _LEGEND_FROM and len(traces) > 1
    legend = [_legend(traces, width, styles.get("axis", ""), tr)] if has_legend else []
    plot = _Plot(traces, width - _MARGIN, height - 2 - len(legend), tr)
    lines = [plot.phase_names(styles), *plot.body(styles), plot.time_axis(styles), *legend]
    return Text("\n", no_wrap=True, end="").join(lines)


def _legend(traces: Sequence[Trace], width: int, style: str | Style, tr: Language) -> Text:
    labels = [
        trace.label or tr("reach {number}", number=number)
        for number, trace in enumerate(traces, start=1)
    ]
    *earlier, newest = labels
    return Text(f"{' ' * _MARGIN}⠒⠒ {newest}   ⠂⠂ {', '.join(earlier)}"[:width].ljust(width), style)


class _Plot:
    """A plot of ``columns`` by ``rows`` cells of 2 by 4 dots, with its scales."""

    def __init__(self, traces: Sequence[Trace], columns: int, rows: int, tr: Language) -> None:
        self.tr = tr
        self.traces, self.newest = traces, traces[-1]
        self.columns, self.rows = columns, rows
        self.from_s = min(-trace.onset_s for trace in traces)
        self.to_s = max((len(trace.rate) - 1) / trace.rate_hz - trace.onset_s for trace in traces)
        self.to_s = max(self.to_s, self.from_s + 0.1)
        high = _ROOM * max(_FLATTEST / 2, *(max(trace.rate, default=0.0) for trace in traces))
        low = _ROOM * min(-_FLATTEST / 2, *(min(trace.rate, default=0.0) for trace in traces))
        self.zero_row = min(rows - 1, round(high / (high - low) * rows - 0.5))
        self._zero_dot = 4 * self.zero_row + 2
        self._unit = max(
            high / max(1, self._zero_dot), -low / max(1, 4 * rows - 1 - self._zero_dot)
        )
        newest = self.newest
        times = [
            t - newest.onset_s
            for t in (newest.onset_s, newest.arrival_s, newest.departure_s, newest.end_s)
        ]
        self.bounds = [self._column(t) for t in times]

    def phase_names(self, styles: Styles) -> Text:
        """Return the line of the newest reach's phases, each in brackets as wide as it lasts."""
        tr, (onset, arrival, departure, end) = self.tr, self.bounds
        line = Text("rad/s".ljust(_MARGIN) + " " * onset, styles.get("axis", ""))
        phases = (("out", tr("out"), arrival - onset), ("dwell", tr("dwell"), departure - arrival))
        for part, name, width in (*phases, ("back", tr("back"), end - departure)):
            line.append(_bracket(name, width), styles.get(part, ""))
        line.pad_right(max(0, self.columns + _MARGIN - len(line)))
        return line

    def body(self, styles: Styles) -> list[Text]:
        """Return the rows between the phases' names and the time axis."""
        strong = self._dots([self.newest])
        faint = self._dots(self.traces[:-1], every=2)
        labels = self._labels()
        lines = []
        for row in range(self.rows):
            axis = "┼" if row == self.zero_row else "┤" if row in labels else "│"
            line = Text(labels.get(row, "").rjust(_MARGIN - 1) + axis, styles.get("axis", ""))
            for column in range(self.columns):
                if dots := int(strong[row, column]):
                    line.append(chr(_BLANK + dots), styles.get(self._phase(column), ""))
                elif dots := int(faint[row, column]):
                    line.append(chr(_BLANK + dots), styles.get("earlier", ""))
                else:
                    empty = "┊" if column in self.bounds else "─" if row == self.zero_row else " "
                    line.append(empty, styles.get("axis", ""))
            lines.append(line)
        return lines

    def time_axis(self, styles: Styles) -> Text:
        """Return the time axis, in seconds since the onset."""
        per_cell = (self.to_s - self.from_s) / self.columns
        step = next(step for step in _STEPS if step >= 9 * per_cell)
        cells = [" "] * (self.columns + _MARGIN)
        for count in range(int(self.to_s / step) + 1):
            label = self.tr.figures(f"{count * step:g} s")
            first = _MARGIN + self._column(count * step) - len(label) // 2
            if first + len(label) <= len(cells):
                cells[first : first + len(label)] = label
        return Text("".join(cells), styles.get("axis", ""))

    def _column(self, time_s: float) -> int:
        share = (time_s - self.from_s) / (self.to_s - self.from_s)
        return min(self.columns - 1, max(0, int(share * self.columns)))

    def _phase(self, column: int) -> str:
        onset, arrival, departure, end = self.bounds
        if not onset <= column <= end:
            return "rest"
        return "out" if column < arrival else "dwell" if column < departure else "back"

    def _dots(self, traces: Sequence[Trace], every: int = 1) -> npt.NDArray[np.uint8]:
        """Return the Braille dots of curves, shape (rows, columns), drawn in every ``every``-th
        column of dots.
        """
        cells = np.zeros((self.rows, self.columns), dtype=np.uint8)
        time = self.from_s + (np.arange(2 * self.columns) + 0.5) / (2 * self.columns) * (
            self.to_s - self.from_s
        )
        for trace in traces:
            own = np.arange(len(trace.rate)) / trace.rate_hz - trace.onset_s
            heights = (
                np.interp(time, own, trace.rate, left=np.nan, right=np.nan)
                if len(own)
                else time * np.nan
            )
            before = None
            for column, height in enumerate(heights.tolist()):
                if math.isnan(height):  # the curve has not begun, or is over
                    before = None
                    continue
                dot = min(4 * self.rows - 1, max(0, self._zero_dot - round(height / self._unit)))
                if column % every == 0:
                    step = 0 if before is None else (before < dot) - (before > dot)
                    for y in range(
                        dot if before is None or not step else before + step,
                        dot + (step or 1),
                        step or 1,
                    ):
                        cells[y // 4, column // 2] |= _DOTS[y % 4][column % 2]
                before = dot
        return cells

    def _labels(self) -> dict[int, str]:
        """Return round numbers, by the row they label."""
        step = next(step for step in _STEPS if step >= 4 * self._unit)
        labels = {}
        for count in range(-self.rows, self.rows + 1):
            dot = self._zero_dot - round(count * step / self._unit)
            if 0 <= dot < 4 * self.rows:
                labels[dot // 4] = self.tr.figures(f"{count * step:g}").replace("-", "−")
        return labels


def _bracket(name: str, width: int) -> str:
    """Return a name in brackets, shortened to fit."""
    if width >= len(name) + 4:
        return "├" + f" {name} ".center(width - 2, "─") + "┤"
    if width >= len(name):
        return name.center(width)
    return "·" * width

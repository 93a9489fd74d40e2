"""Text chart of sessions, first to last: a value with its band in each column, and rows of figures
below them.

Characters alone carry the meaning; colours may be added by character.
"""

import math
import statistics
from collections.abc import Callable, Iterator, Sequence
from datetime import date

import msgspec

POINT, BAND, AREA, RULE, CHOSEN = "●", "│", "░", "╌", "▲"
TEN = "X"
"""Stands for 10 where there is room for one character."""
ABOVE, BELOW, UNKNOWN = "^", "v", "?"
"""Stand for a session without a value: it lies above or below what could be measured, or is not
known.
"""
MARKED = "◆"
"""Stands for the session that another one is compared with."""
EVENT = "!"
"""Stands for an adverse event."""
BARS = "▁▂▃▄▅▆▇█"
_WIDEST = 10
"""Most columns that a session has, so that a few sessions stay together."""
_GAP = 2
"""Least number of blanks between two dates."""
_LONG_DAYS = 300
"""From this time on, dates below the axis have years instead of days."""
_ROOM = 1.2
"""Room beyond the outermost values, in bands: one session with a very wide band must not flatten
all others.
"""


_ROUNDING = 1e-9
"""Share of a value below which a difference is an error of rounding."""


class Value(msgspec.Struct, frozen=True):
    """A session's value and its band, or the character that stands for one without a value."""

    value: float | None = None
    low: float | None = None
    high: float | None = None
    without: str = ""


class Columns(msgspec.Struct, frozen=True):
    """Columns of sessions in a chart; a column holds several sessions if there are more sessions
    than columns.
    """

    count: int
    width: int

    @property
    def step(self) -> float:
        """Columns from one session to the next."""
        return min(_WIDEST, self.width / max(1, self.count))

    @property
    def most(self) -> int:
        """Largest number of sessions in a column."""
        return max(1, math.ceil(1 / self.step))

    def column(self, session: int) -> int:
        """Return the column of a session (0, 1, …)."""
        return min(self.width - 1, int((session + 0.5) * self.step))

    def groups(self) -> Iterator[tuple[int, range]]:
        """Yield each column that has sessions, with them."""
        first = 0
        for session in range(1, self.count + 1):
            if session == self.count or self.column(session) != self.column(first):
                yield self.column(first), range(first, session)
                first = session

    def figures(self, values: Sequence[int | None]) -> str:
        """Return a row with the greatest number of each column, or ``·``; `TEN` is 10 where there
        is no room.
        """
        line = [" "] * self.width
        for column, sessions in self.groups():
            known = [value for session in sessions if (value := values[session]) is not None]
            text = str(max(known)) if known else "·"
            if len(text) > 1 and self.step < len(text) + 1:
                text = TEN
            line[column : column + len(text)] = text
        return "".join(line).rstrip()

    def signs(self, marked: Sequence[bool], sign: str) -> str:
        """Return a row with a sign in each column that has a marked session."""
        line = [" "] * self.width
        for column, sessions in self.groups():
            if any(marked[session] for session in sessions):
                line[column] = sign
        return "".join(line).rstrip()

    def numbers(self, values: Sequence[float | None], form: str) -> str:
        """Return a row of numbers, formatted by ``form``, where they have room; else of bars."""
        texts = [form.format(value) if value is not None else "·" for value in values]
        if max(map(len, texts), default=0) >= self.step:
            return self.bars(values)
        line = [" "] * self.width
        for session, text in enumerate(texts):
            begin = min(self.column(session), self.width - len(text))
            line[begin : begin + len(text)] = text
        return "".join(line).rstrip()

    def bars(self, values: Sequence[float | None]) -> str:
        """Return a row of bars between the least and the greatest value; ``·`` where there is
        none.
        """
        line = [" "] * self.width
        means = [
            (column, _mean([values[session] for session in sessions]))
            for column, sessions in self.groups()
        ]
        known = [mean for _, mean in means if mean is not None]
        for column, mean in means:
            line[column] = (
                "·" if mean is None else BARS[_part(mean, min(known), max(known), len(BARS) - 1)]
            )
        return "".join(line).rstrip()

    def dates(self, days: Sequence[str], months: Sequence[str]) -> str:
        """Return a row of dates as far as there is room; the last one is always there.

        Args:
            days: of each session ("2026-03-02"); at least one.
            months: short names of the months.
        """
        is_long = _days(days[0], days[-1]) > _LONG_DAYS
        texts = [
            day[:7] if is_long else f"{int(day[8:])} {months[int(day[5:7]) - 1]}" for day in days
        ]
        line = [" "] * self.width
        last = min(self.column(len(days) - 1), self.width - len(texts[-1]))
        line[last:] = texts[-1]
        free, before = 0, texts[-1]
        for column, sessions in self.groups():
            shown = texts[sessions[0]]
            if free <= column <= last - len(shown) - _GAP and shown != before:
                line[column : column + len(shown)] = shown
                free, before = column + len(shown) + _GAP, shown
        return "".join(line)


def limits(values: Sequence[Value], more: Sequence[float] = ()) -> tuple[float, float]:
    """Return the lowest and the highest value of an axis, with room for most of the bands.

    Args:
        values: at least one has a value.
        more: values that must be on the axis as well.
    """
    known = [*(each.value for each in values if each.value is not None), *more]
    halves = [
        (each.high - each.low) / 2
        for each in values
        if each.high is not None and each.low is not None
    ]
    room = _ROOM * statistics.median(halves) if halves else 0.0
    low, high = min(known) - room, max(known) + room
    if low == high:
        room = 0.1 * abs(high) or 1.0
        return low - room, high + room
    return low, high


def session_chart(
    values: Sequence[Value],
    columns: Columns,
    *,
    axis: tuple[float, float],
    ticks: Sequence[tuple[float, str]],
    rows: int,
    margin: int,
    area: tuple[float, float] | None = None,
    rule: float | None = None,
    chosen: int | None = None,
    marked: int | None = None,
) -> list[str]:
    """Draw values over sessions. Those without a value have a row of their own above or below the
    others.

    Args:
        values: of each session; of several in a column, the means are drawn.
        columns: where the sessions are.
        axis: lowest and highest value.
        ticks: values with their labels.
        rows: number of rows above the axis.
        margin: columns for the labels and the axis.
        area: values between which all is shaded.
        rule: value at which a dashed line is drawn.
        chosen, marked: sessions with a sign of their own on the axis.

    Returns:
        ``rows`` + 1 lines.
    """
    low, high = axis
    above, below = (_signs(values, columns, signs) for signs in (ABOVE, BELOW + UNKNOWN))
    rows -= bool(above) + bool(below)

    def row(value: float) -> int:
        return rows - 1 - _part(value, low, high, rows - 1)

    grid = [[" "] * columns.width for _ in range(rows)]
    if area and area[0] <= high and area[1] >= low:
        for line in range(row(min(area[1], high)), row(max(area[0], low)) + 1):
            grid[line] = [AREA] * columns.width
    if rule is not None and low <= rule <= high:
        grid[row(rule)] = [RULE] * columns.width
    for column, sessions in columns.groups():
        _draw([values[session] for session in sessions], column, grid, row)
    labels: dict[int, str] = {}
    for value, label in sorted(
        ticks, key=lambda tick: -abs(low + (high - low) * _share(row(tick[0]), rows) - tick[0])
    ):
        if low <= value <= high:
            labels[row(value)] = label  # of several, the one next to the middle of the row
    lines = []
    for number, cells in enumerate(grid):
        axis_line = "┤" if number in labels else "│"
        label = f"{labels.get(number, ''):>{margin - 1}}"
        lines.append(f"{label}{axis_line}{''.join(cells)}".rstrip())
    edge = f"{'│':>{margin}}"
    lines = [*([edge + above] if above else []), *lines, *([edge + below] if below else [])]
    foot = ["─"] * columns.width
    for session, sign in ((marked, MARKED), (chosen, CHOSEN)):
        if session is not None:
            foot[columns.column(session)] = sign
    return [*lines, f"{'└':>{margin}}{''.join(foot)}"]


def _draw(
    values: Sequence[Value], column: int, grid: list[list[str]], row: Callable[[float], int]
) -> None:
    value, low, high = (
        _mean([getattr(each, name) for each in values]) for name in ("value", "low", "high")
    )
    if value is None:
        return
    if low is not None and high is not None:
        for line in range(row(high), row(low) + 1):
            grid[line][column] = BAND
    grid[row(value)][column] = POINT


def _signs(values: Sequence[Value], columns: Columns, wanted: str) -> str:
    """Return a row with the signs of columns that have no value, as far as they are wanted; empty
    for none.
    """
    line = [" "] * columns.width
    for column, sessions in columns.groups():
        found = [values[session] for session in sessions]
        if all(each.value is None for each in found):
            line[column] = next(
                (each.without for each in found if each.without and each.without in wanted), " "
            )
    return "".join(line).rstrip()


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return statistics.fmean(known) if known else None


def _part(value: float, low: float, high: float, steps: int) -> int:
    """Return the step of a value between two others, 0 to ``steps``; those beyond are at the
    ends.
    """
    if high - low <= _ROUNDING * max(abs(low), abs(high)):
        return steps // 2
    return max(0, min(steps, round((value - low) / (high - low) * steps)))


def _share(row: int, rows: int) -> float:
    """Return the height of the middle of a row on the axis, 0 to 1."""
    return (rows - 1 - row) / max(1, rows - 1)


def _days(first: str, last: str) -> int:
    return (date.fromisoformat(last) - date.fromisoformat(first)).days

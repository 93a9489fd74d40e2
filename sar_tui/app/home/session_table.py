"""The list of sessions as a table: which columns there is room for, and its lines. Pure."""

from collections.abc import Sequence
from datetime import date

import msgspec
from textual.content import Content

from sar_tui.app.home.words import bars, day_words

ROOMY = 90
"""Columns from which on a table has room for more."""
_GAP = " "


class Line(msgspec.Struct, frozen=True):
    """A session: the cells of its line. ``levels`` are those of its attempts, ``note`` stands at
    the end.
    """

    day: date
    clock: str
    who: str
    task: str
    levels: Sequence[int]
    result: str
    reached: str
    minutes: int
    note: str


class Table:
    """The table for a list of sessions.

    Args:
        lines: the sessions.
        width: columns that there is room for.
        today: the date.
        names_who: True if they are sessions of several participants.
    """

    def __init__(self, lines: Sequence[Line], width: int, today: date, *, names_who: bool) -> None:
        self._lines, self._width, self._today = lines, width, today
        self._highest = max((level for line in lines for level in line.levels), default=1)
        is_roomy = width >= ROOMY
        columns = {"Date": 11}
        if is_roomy:
            columns["Time"] = 5
        if names_who:
            columns["Who"] = 12 if is_roomy else 8
        if names_who or len({line.task for line in lines}) > 1:
            columns["Task"] = 20 if is_roomy else 12
        if is_roomy or not names_who:
            columns |= {"Level": 7 if is_roomy else 5, "Result": 8 if is_roomy else 6}
        columns["Reached"] = 8
        longest = max((len(line.levels) for line in lines), default=0)
        columns["Levels"] = min(max(longest + 1, 7), 40 if is_roomy else 12)
        if is_roomy:
            columns["Minutes"] = 7
        self._columns = columns

    @property
    def heading(self) -> str:
        """The names of the columns."""
        return _GAP.join(f"{name:<{width}}" for name, width in self._columns.items()).rstrip()

    def draw(self, line: Line) -> Content:
        """Return the line of a session."""
        cells = {
            "Date": day_words(line.day, self._today),
            "Time": line.clock,
            "Who": line.who,
            "Task": line.task,
            "Level": _from_to(line.levels),
            "Result": line.result,
            "Reached": line.reached,
            "Levels": bars(line.levels, self._highest, self._columns["Levels"]),
            "Minutes": f"{line.minutes} min" if line.minutes else "",
        }
        columns = dict(self._columns)
        if sum(columns.values()) + len(columns) * len(_GAP) + len(line.note) > self._width:
            del columns["Levels"]  # why a session stands out says more
            columns.pop("Minutes", None)
        drawn = _GAP.join(_fitted(cells[name], width) for name, width in columns.items())
        return Content(f"{drawn}{_GAP}{line.note}").truncate(self._width, ellipsis=True)


def _from_to(levels: Sequence[int]) -> str:
    if not levels:
        return ""
    return str(levels[0]) if levels[0] == levels[-1] else f"{levels[0]}→{levels[-1]}"


def _fitted(text: str, width: int) -> str:
    return f"{text[: width - 1]}…" if len(text) > width else f"{text:<{width}}"

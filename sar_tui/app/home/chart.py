"""A participant's sessions as a small chart: a bar for the level of each, its number and its result below."""

from collections.abc import Sequence
from datetime import date

from textual.content import Content
from textual.widget import Widget

from sar_tui.app.home.words import BARS, Past, day_words

LABEL = 11
"""Columns of the labels at the left, on the chart as on the rest of the card."""
_COLUMNS = (7, 12)
"""Narrowest and widest column of a session."""
_BAR = 3
_SPREAD = 8
"""Fewer sessions do not spread over the whole width."""
_LEAST_TOP = 4
"""A chart reaches at least to this level, so that the first levels do not fill it."""

Row = tuple[str, str, bool]
"""Label, text, and True for a row of bars."""


def draw(past: Sequence[Past], width: int, height: int) -> list[Row]:
    """Return the rows of the chart, with as many of the newest sessions as there is room for.

    The dates are left out if there are only three rows.
    """
    narrowest, widest = _COLUMNS
    room = max(narrowest, width - LABEL)
    shown = [each for each in past if each.level is not None][-(room // narrowest) :]
    if not shown:
        return []
    column = min(widest, room // max(len(shown), min(_SPREAD, room // narrowest)))
    levels = [each.level or 0 for each in shown]
    below = 3 if height > 3 else 2
    rows = max(1, height - below)
    top = max(*levels, _LEAST_TOP)
    drawn: list[Row] = [
        ("", _cells([_part(level / top, row, rows) * _BAR for level in levels], column), True) for row in range(rows)
    ]
    results = [each.result.partition(" ") for each in shown]
    unit = results[-1][2]
    drawn.append(("Level", _cells([str(level) for level in levels], column), False))
    name = f"Result ({unit})" if unit else "Result"
    drawn.append((name[: LABEL - 1], _cells([figure for figure, *_ in results], column), False))
    if below == 3:
        drawn.append(("", _cells([_short_day(each.day) for each in shown], column), False))
    return drawn


def _part(share: float, row: int, rows: int) -> str:
    """Return the character of a bar in a row, counted from above; empty above its end."""
    eighths = max(1, round(share * rows * 8)) - (rows - 1 - row) * 8
    return BARS[min(eighths, 8) - 1] if eighths > 0 else ""


def _short_day(day: date) -> str:
    return day_words(day, day.replace(year=day.year - 1)).rpartition(" ")[0]


def _cells(texts: Sequence[str], column: int) -> str:
    return "".join(f"{text[: column - 1]:^{column}}" for text in texts).rstrip()


class SessionChart(Widget):
    """Draws the chart as large as there is room. It changes only by ``show``."""

    DEFAULT_CSS = "SessionChart { height: 1fr; min-height: 3; max-height: 13; }"

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._past: Sequence[Past] = ()
        self._without = ""

    def show(self, past: Sequence[Past], without: str) -> None:
        """Show sessions; ``without`` any, these words."""
        self._past, self._without = past, without
        self.refresh()

    def render(self) -> Content:
        rows = draw(self._past, self.size.width, self.size.height)
        if not rows:
            return Content(self._without)
        return Content("\n").join(
            Content.assemble((f"{label:<{LABEL}}", "$text-muted"), (text, "$text-muted" if is_bar else "$foreground"))
            for label, text, is_bar in rows
        )

"""A participant's comparable sessions as a small chart: a bar for the level at goal of each, and
figures below.
"""

from collections.abc import Sequence
from datetime import date
from typing import TYPE_CHECKING, Any

import msgspec
from textual.content import Content
from textual.widget import Widget

from sar_tui.app.home.words import short_day
from sar_tui.model.language import Language

if TYPE_CHECKING:  # the empty screen is shown before it is loaded
    from sar_tui.reports.progress import LineProgress, SessionProgress

LABEL = 11
"""Columns of the labels at the left, on the chart as on the rest of the card."""
_COLUMNS = (7, 12)
"""Narrowest and widest column of a session."""
_BAR = 3
_SPREAD = 8
"""Fewer sessions do not spread over the whole width."""
_LEAST_TOP = 4
"""A chart reaches at least to this level, so that the first levels do not fill it."""


class Bar(msgspec.Struct, frozen=True):
    """A session: its day, the height of its bar (0 to 1; more is better), its value, and the goals
    reached in it.
    """

    day: date
    height: float
    value: str
    reached: str = ""


class Chart(msgspec.Struct, frozen=True):
    """Sessions, oldest first. ``label`` names their values."""

    label: str = ""
    bars: Sequence[Bar] = ()


def charted(line: "LineProgress", tr: Language) -> Chart:
    """Return the chart of a line: of the levels at goal, or of the mean results where the level
    never changed.
    """
    from sar_tui.model.results_for_people import metric_for_people

    metric, factor = metric_for_people(line.metric)
    is_result = line.measure == "result"
    label = tr("Level at goal")
    if is_result:
        label = tr("Result ({unit})", unit=metric.unit) if metric.unit else tr("Result")
    known = [each.at_goal.level for each in line.sessions if each.at_goal and each.at_goal.level]
    highest = max([*known, _LEAST_TOP])
    means = [each.mean for each in line.sessions if each.mean is not None]
    bars = []
    for each in line.sessions:
        if not is_result:
            height, value = _at_goal(line, each, highest)
            value = tr.figures(value)
        elif each.mean is None:
            height, value = 0.0, "?"
        else:
            height, value = (
                _of_best(line, each.mean, means),
                tr.figures(f"{each.mean * factor:.{metric.decimals}f}"),
            )
        reached = "" if each.reached is None else f"{each.reached}/{each.attempts}"
        bars.append(Bar(date.fromisoformat(each.began[:10]), height, value, reached))
    return Chart(label, bars)


def _at_goal(line: "LineProgress", session: "SessionProgress", highest: float) -> tuple[float, str]:
    """Return the height and the level at goal of a session; it may be known only to lie above or
    below some level.
    """
    if session.at_goal and session.at_goal.level:
        return session.at_goal.level / highest, f"{session.at_goal.level:.1f}"
    if session.at_goal and line.places:
        is_above = session.at_goal.difficulty > line.places[-1]
        return (1.0, f">{len(line.places)}") if is_above else (0.0, "<1")
    levels = session.level_means
    if session.side == "easier" and levels:
        return 1.0, f">{max(levels)}"
    return 0.0, f"<{min(levels)}" if session.side == "harder" and levels else "?"


def _of_best(line: "LineProgress", mean: float, means: Sequence[float]) -> float:
    """Return a mean result as a share of the best one; 0 where results are not all above zero."""
    if min(means) <= 0:
        return 0.0
    return min(means) / mean if line.metric.better == "lower" else mean / max(means)


def draw(chart: Chart, width: int, height: int, tr: Language) -> list[Content]:
    """Return the rows of a chart, with as many of the newest sessions as there is room for; the bar
    of the last one stands out.

    With few rows the blank row above is left out first, then the dates, the goals reached, and the
    caption.
    """
    narrowest, widest = _COLUMNS
    room = max(narrowest, width - LABEL)
    shown = chart.bars[-(room // narrowest) :]
    if not shown:
        return []
    column = min(widest, room // max(len(shown), min(_SPREAD, room // narrowest)))

    def row(label: str, texts: Sequence[str]) -> Content:
        return Content.assemble((f"{label:<{LABEL}}", "$text-muted"), _cells(texts, column))

    above: list[Content] = []
    below = [row("", [bar.value for bar in shown])]
    if height >= 3:
        above = [Content.styled(_caption(chart.label, len(shown), tr), "$text-muted")]
    if height >= 4 and any(bar.reached for bar in shown):
        below.append(row(tr("Reached"), [bar.reached for bar in shown]))
    if height > len(above) + len(below) + 1:
        below.append(row("", [short_day(bar.day, tr) for bar in shown]))
    if height > len(above) + len(below) + 2:
        above.insert(0, Content(""))
    rows = max(1, height - len(above) - len(below))
    for number in range(rows):
        parts = [_part(bar.height, number, rows) * _BAR for bar in shown]
        *earlier, last = (f"{part:^{column}}" for part in parts)
        above.append(
            Content.assemble(
                (" " * LABEL + "".join(earlier), "$text-muted"), (last, "$accent")
            ).rstrip()
        )
    return [*above, *below]


def _caption(label: str, count: int, tr: Language) -> str:
    return label if count == 1 else tr("{what}, last {count} sessions", what=label, count=count)


def _part(share: float, row: int, rows: int) -> str:
    """Return the character of a bar in a row, counted from above; empty above its end."""
    from sar_tui.reports.charts import BARS

    eighths = max(1, round(share * rows * 8)) - (rows - 1 - row) * 8
    return BARS[min(eighths, 8) - 1] if eighths > 0 else ""


def _cells(texts: Sequence[str], column: int) -> str:
    return "".join(f"{text[: column - 1]:^{column}}" for text in texts).rstrip()


class SessionChart(Widget):
    """Draws the chart as large as there is room. It changes only by ``show``."""

    app: Any
    DEFAULT_CSS = "SessionChart { height: 1fr; min-height: 3; max-height: 13; }"

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._chart = Chart()
        self._without = ""

    def show(self, chart: Chart, without: str) -> None:
        """Show a chart; ``without`` any session, these words."""
        self._chart, self._without = chart, without
        self.refresh()

    def render(self) -> Content:
        rows = draw(self._chart, self.size.width, self.size.height, self.app.tr)
        if not rows:
            return Content(self._without)
        return Content("\n").join(rows)

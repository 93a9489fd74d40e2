"""A result and its goal as two bars from zero on one scale, and the words that judge it."""

from collections.abc import Sequence
from itertools import groupby
from typing import NamedTuple

from textual.content import Content

from sar_tui.model.language import Language
from sar_tui.model.messages import Feedback
from sar_tui.model.results_for_people import decimals_for, result_text
from sar_tui.model.trial_types import Metric

SHORTEST, LONGEST = 12, 72
"""Columns of the longer bar, without the words beside it."""
FARTHEST = 2.0
"""A bar ends in an arrow at this multiple of the goal: a longer one would tell nothing more."""
BAR, THICK, BEYOND = "━", "█", "▶"
REACHED, OPEN = "✓", "○"
_GAP = "\N{NO-BREAK SPACE}"
"""A space that stays where lines are centred."""


class GoalBar(NamedTuple):
    """A result beside its goal. ``who``: the participant's name if there are several, else
    empty.
    """

    metric: Metric
    value: float
    goal: float
    who: str = ""

    @property
    def is_reached(self) -> bool:
        """True if the result is better than its goal."""
        return self.metric.is_better(self.value, self.goal)


def bar_of(feedback: Feedback, metric: Metric, who: str = "") -> GoalBar | None:
    """Return the bar that goes with feedback in figures; None where a bar would say more than the
    words, or mislead.

    It would after a race, for several attempts together, and if too few responses were right or
    none was timed.
    """
    choice, value = feedback.choice, feedback.metric
    says_result = (
        choice.form != "qualitative" and choice.content != "performance" and choice.attempts == 1
    )
    if not says_result or feedback.reason not in ("goal", "missed", "band"):
        return None
    if value is None or value < 0 or feedback.goal <= 0:
        return None
    return GoalBar(metric, value, feedback.goal, who)


def rows_of_bars(bars: Sequence[GoalBar], *, is_large: bool = False) -> int:
    """Return the rows that `draw_bars` takes."""
    drawn = len(bars) + len(_by_goal(bars))
    return 3 * drawn - 1 if is_large else drawn


def draw_bars(
    bars: Sequence[GoalBar], width: int, tr: Language, *, is_large: bool = False
) -> Content:
    """Return a bar for each result, and one for its goal below it. Empty if there is no room.

    Of several results each has a sign at its end. Beside a result alone words say it where the
    shorter bar is the better one.

    Args:
        bars: the results, those with the same goal beside each other.
        width: columns that may be taken.
        tr: language of the words.
        is_large: bars are two rows thick, with a blank row between them.
    """
    rows = [row for same in _by_goal(bars) for row in _rows(same, tr)]
    names = max(len(row.name) for row in rows)
    values = max(len(row.value) for row in rows)
    columns = min(LONGEST, width - names - values - 2 - 2 * (len(bars) > 1))
    if columns < SHORTEST:
        return Content("")
    longest = max(row.length for row in rows)
    shortest = min(row.length for row in rows)
    hint = _hint(bars, tr)
    if columns - len(hint) < SHORTEST:
        hint = ""
    part = max(shortest / longest, 1 / columns)
    most = min(columns, int((columns - len(hint)) / part))
    drawn = []
    for row in rows:
        bar = _bar(row, round(row.length / longest * most), THICK if is_large else BAR)
        said = hint if row.length == shortest else ""
        rest = _GAP * (columns - len(bar) - len(said))
        sign = f"{_GAP}{row.sign or _GAP}" if len(bars) > 1 else ""
        words = f"{row.name:{_GAP}>{names}}{_GAP}{row.value:{_GAP}>{values}}{_GAP}"
        drawn.append(Content.assemble(words, (bar, row.style), (said, "$text-muted"), rest, sign))
        if is_large:
            below = _GAP * len(words), (bar, row.style), rest, _GAP * (len(sign) + len(said))
            drawn += [Content.assemble(*below), Content("")]
    if is_large:
        drawn.pop()
    return Content("\n").join(drawn)


def verdict(bar: GoalBar, tr: Language) -> str:
    """Return whether the goal is reached, in words; if it is not, with a sign."""
    return tr("Goal reached") if bar.is_reached else f"{tr('Not yet at your goal')} {OPEN}"


def _hint(bars: Sequence[GoalBar], tr: Language) -> str:
    """Return that the shorter bar is the better one, for a result alone; empty if the longer is."""
    metric = bars[0].metric
    if len(bars) > 1 or metric.better != "lower":
        return ""
    words = tr("shorter is {better}", better=tr(metric.improved))
    return f"  {words}".replace(" ", _GAP)


class _Row(NamedTuple):
    """A bar with its words. ``length``: in parts of the goal; ``sign``: says that it is reached."""

    name: str
    value: str
    length: float
    style: str
    sign: str = ""


def _by_goal(bars: Sequence[GoalBar]) -> list[list[GoalBar]]:
    return [list(same) for _, same in groupby(bars, lambda bar: bar.goal)]


def _rows(bars: Sequence[GoalBar], tr: Language) -> list[_Row]:
    """Return the rows of results with the same goal, and that of the goal."""
    rows = []
    metric, goal = bars[0].metric, bars[0].goal
    decimals = max(decimals_for(metric, bar.value, goal) or 0 for bar in bars)
    for bar in bars:
        value = result_text(bar.metric, bar.value, tr, decimals)
        style = "$success" if bar.is_reached else "$accent"
        length = min(bar.value / bar.goal, FARTHEST)
        rows.append(
            _Row(bar.who or tr("you"), value, length, style, REACHED if bar.is_reached else OPEN)
        )
    value = result_text(metric, goal, tr, decimals)
    return [*rows, _Row(tr("goal"), value, 1.0, "$text-muted")]


def _bar(row: _Row, columns: int, part: str) -> str:
    """Return a bar; an arrow ends one that is longer than all that is drawn."""
    if row.length >= FARTHEST:
        return part * (columns - 1) + BEYOND
    return part * max(1, columns)

"""A line that grows with the result, with its goal marked on it: readable without colour, and in no
need of figures.
"""

from typing import NamedTuple

from textual.content import Content

from sar_tui.model.language import Language
from sar_tui.model.messages import Feedback
from sar_tui.model.results_for_people import goal_text
from sar_tui.model.trial_types import Metric

LONGEST, SHORTEST = 40, 12
"""Columns of the line, without the words beside it."""
FARTHEST = 2.0
"""The line ends in an arrow at this multiple of the goal: a longer one would tell nothing more."""
DONE, REST, GOAL, BEYOND, REACHED = "━", "─", "┊", "▶", "✓"


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


def draw_bars(bars: list[GoalBar], width: int, tr: Language) -> Content:
    """Return a row for each bar: "you ━━━━━━────────────┊ goal: less than 1 second ✓". Empty if
    there is no room.

    The mark is there if the goal is reached.
    """
    names = [bar.who or tr("you") for bar in bars]
    goals = [_goal(bar, tr) for bar in bars]
    left, right = (max((len(text) for text in texts), default=0) for texts in (names, goals))
    columns = min(LONGEST, width - left - right - 2)
    if columns < SHORTEST:
        return Content("")
    rows = []
    for name, bar, goal in zip(names, bars, goals, strict=True):
        done, rest = line(bar, columns)
        row = (
            (f"{name:>{left}} ", "$text-muted"),
            (done, "$accent"),
            (rest, "$text-muted"),
            f" {goal:<{right}}",
        )
        rows.append(Content.assemble(*row))
    return Content("\n").join(rows)


def line(bar: GoalBar, columns: int) -> tuple[str, str]:
    """Return the part of the line up to the result, with the goal if that is nearer, and the part
    beyond.

    A better result has the longer line: of a time, the goal in parts of the result is drawn. The
    goal is at the right end if the result has not passed it; else the result is there.
    """
    reached, whole = bar.value, bar.goal
    if bar.metric.better == "lower":
        reached, whole = whole, reached
    share = reached / whole if whole else FARTHEST
    if share <= 1:
        done = min(columns - 1, round(share * (columns - 1)))
        return DONE * done, REST * (columns - 1 - done) + GOAL
    at = max(1, round((columns - 1) / min(share, FARTHEST)))
    at = min(at, columns - 2)
    tip = BEYOND if share > FARTHEST else DONE
    return DONE * at + GOAL + DONE * (columns - at - 2) + tip, ""


def _goal(bar: GoalBar, tr: Language) -> str:
    goal = goal_text(bar.metric, bar.goal, tr)
    if bar.metric.better == "lower":
        words = tr("goal: less than {goal}", goal=goal)
    else:
        words = tr("goal: more than {goal}", goal=goal)
    return f"{words} {REACHED}" if bar.is_reached else words

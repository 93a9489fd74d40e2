"""The bars of a participant's result and the goal."""

from typing import Any

import pytest

from sar_tui.model.language import Language
from sar_tui.model.messages import Feedback, FeedbackChoice
from sar_tui.model.trial_types import Metric
from sar_tui.widgets.goal_bar import GoalBar, bar_of, draw_bars, rows_of_bars, verdict

TIME = Metric("reaction_time", unit="ms", better="lower")
FAST = Metric("reaction_time", unit="ms", better="lower", improved="faster", worsened="slower")
TAPS = Metric("taps", unit="taps", better="higher")
CHOICE: dict[str, Any] = {
    "schedule": "every", "due": True, "why": "", "content": "results", "form": "both",
    "compared_with": "goal", "degree": "clear",
}  # fmt: skip


def feedback(
    reason: Any = "goal", metric: float | None = 400.0, goal: float = 1000.0, **choice: Any
) -> Feedback:
    return Feedback(
        attempt=1, level=1, valence="positive", reason=reason, metric=metric, goal=goal,
        accuracy=1.0, correct=2, trials=2, reached=1, choice=FeedbackChoice(**CHOICE | choice),
    )  # fmt: skip


def drawn(*bars: GoalBar, width: int = 68) -> list[str]:
    drawn = draw_bars(list(bars), width, Language()).plain.replace("\N{NO-BREAK SPACE}", " ")
    return [line.rstrip() for line in drawn.splitlines()]


@pytest.mark.parametrize(
    ("value", "you", "goal"),
    [
        (0, 1, 40), (400, 16, 40), (1000, 40, 40), (1600, 40, 25), (2000, 40, 20), (60_000, 40, 20),
    ],
)  # fmt: skip
def test_both_bars_begin_at_zero_and_have_one_scale(value: float, you: int, goal: int) -> None:
    bar = GoalBar(TAPS, value, 1000.0)
    words = len(drawn(bar)[0].rstrip("━▶"))
    lines = drawn(bar, width=words + 40)
    assert [line.count("━") + line.count("▶") for line in lines[:2]] == [you, goal]
    assert lines[0].endswith("▶") == (value >= 2000)


@pytest.mark.parametrize(
    ("bar", "words"),
    [
        (GoalBar(FAST, 400, 1000), "Goal reached"),
        (GoalBar(FAST, 1000, 1000), "Not yet at your goal ○"),
        (GoalBar(TAPS, 12, 10), "Goal reached"),
        (GoalBar(TAPS, 10, 10), "Not yet at your goal ○"),
    ],
)
def test_words_say_whether_the_goal_is_reached(bar: GoalBar, words: str) -> None:
    assert verdict(bar, Language()) == words


@pytest.mark.parametrize("value", [0, 1, 400, 690, 700, 900, 5000])
def test_where_less_is_better_words_beside_the_shorter_bar_say_so(value: float) -> None:
    rows = drawn(GoalBar(FAST, value, 700))
    assert max(map(len, rows)) <= 68
    shorter = rows[0] if value <= 700 else rows[1]
    assert shorter.endswith("━  shorter is faster")
    lengths = [row.count("━") + row.count("▶") for row in rows]
    assert lengths[0] / lengths[1] == pytest.approx(min(value / 700, 2), abs=0.05)


def test_where_more_is_better_a_long_bar_speaks_for_itself() -> None:
    assert not any("shorter" in row for row in drawn(GoalBar(TAPS, 12, 10)))
    assert not any("shorter" in row for row in drawn(GoalBar(FAST, 400, 700), width=48))


def test_a_result_and_its_goal_are_labelled_with_their_units() -> None:
    you, goal = drawn(GoalBar(TIME, 450, 700))[:2]
    assert you.startswith(" you 0.45 seconds ━")
    assert goal.startswith("goal 0.70 seconds ━")


def test_a_result_that_looks_like_its_goal_has_one_more_decimal() -> None:
    you, goal = drawn(GoalBar(TIME, 699, 700))
    assert "0.699 seconds" in you
    assert "0.700 seconds" in goal


def test_two_participants_have_a_bar_each_above_their_goal() -> None:
    first, second, goal = drawn(GoalBar(TIME, 400, 1000, "Ana"), GoalBar(TIME, 1700, 1000, "P02"))
    assert first.startswith(" Ana 0.40 seconds ━")
    assert second.startswith(" P02 1.70 seconds ━")
    assert goal.startswith("goal 1.00 seconds ━")
    assert (first[-1], second[-1]) == ("✓", "○")


@pytest.mark.parametrize("is_large", [False, True])
@pytest.mark.parametrize(
    "bars",
    [
        [GoalBar(TIME, 400, 1000)],
        [GoalBar(TIME, 400, 1000, "Ana"), GoalBar(TIME, 700, 1000, "P02")],
        [GoalBar(TIME, 400, 1000, "Ana"), GoalBar(TIME, 700, 900, "P02")],
    ],
)
def test_bars_take_as_many_rows_as_foretold(bars: list[GoalBar], is_large: bool) -> None:
    rows = draw_bars(bars, 68, Language(), is_large=is_large).plain.split("\n")
    assert len(rows) == rows_of_bars(bars, is_large=is_large)
    assert len({len(row) for row in rows if "━" in row}) <= 1


def test_a_narrow_window_has_no_bar() -> None:
    assert drawn(GoalBar(TIME, 400, 1000), width=28) == []


def test_feedback_in_figures_has_a_bar() -> None:
    assert bar_of(feedback(), TIME) == GoalBar(TIME, 400.0, 1000.0)
    assert bar_of(feedback("missed", 1900.0), TIME, "Ana") == GoalBar(TIME, 1900.0, 1000.0, "Ana")


@pytest.mark.parametrize(
    "other",
    [
        feedback("accuracy"), feedback("empty", None), feedback("won"), feedback(metric=None),
        feedback(goal=0.0), feedback(metric=-1.0), feedback(form="qualitative"),
        feedback(content="performance"), feedback(attempts=3),
    ],
)  # fmt: skip
def test_nothing_else_has_one(other: Feedback) -> None:
    assert bar_of(other, TIME) is None

"""The bar from a participant's result to the goal."""

from typing import Any

import pytest

from sar_tui.model.language import Language
from sar_tui.model.messages import Feedback, FeedbackChoice
from sar_tui.model.trial_types import Metric
from sar_tui.widgets.goal_bar import GoalBar, bar_of, draw_bars, line

TIME = Metric("reaction_time", unit="ms", better="lower")
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
    return draw_bars(list(bars), width, Language()).plain.splitlines()


@pytest.mark.parametrize(
    ("metric", "value", "looks"),
    [
        (TAPS, 0, "───────────────────┊"), (TAPS, 400, "━━━━━━━━───────────┊"),
        (TAPS, 1000, "━━━━━━━━━━━━━━━━━━━┊"), (TAPS, 1900, "━━━━━━━━━━┊━━━━━━━━━"),
        (TAPS, 60_000, "━━━━━━━━━━┊━━━━━━━━▶"), (TIME, 60_000, "───────────────────┊"),
        (TIME, 2000, "━━━━━━━━━━─────────┊"), (TIME, 1000, "━━━━━━━━━━━━━━━━━━━┊"),
        (TIME, 600, "━━━━━━━━━━━┊━━━━━━━━"), (TIME, 400, "━━━━━━━━━━┊━━━━━━━━▶"),
        (TIME, 0, "━━━━━━━━━━┊━━━━━━━━━"),
    ],
)  # fmt: skip
def test_the_better_the_result_the_longer_the_line_and_past_the_goal_if_it_is_reached(
    metric: Metric, value: float, looks: str
) -> None:
    assert "".join(line(GoalBar(metric, value, 1000.0), 20)) == looks


def test_the_words_say_on_which_side_of_the_goal_it_is_good() -> None:
    assert "━━━━━━ goal: less than 1 second" in drawn(GoalBar(TIME, 600, 1000))[0]
    assert "━━━━━━ goal: more than 10 taps" in drawn(GoalBar(TAPS, 12, 10))[0]


@pytest.mark.parametrize(
    ("bar", "is_reached"),
    [
        (GoalBar(TIME, 400, 1000), True), (GoalBar(TIME, 1000, 1000), False),
        (GoalBar(TIME, 1900, 1000), False), (GoalBar(TAPS, 12, 10), True),
        (GoalBar(TAPS, 10, 10), False), (GoalBar(TAPS, 4, 10), False),
    ],
)  # fmt: skip
def test_a_mark_says_that_the_goal_is_reached(bar: GoalBar, is_reached: bool) -> None:
    assert drawn(bar)[0].endswith(" ✓") == is_reached


def test_two_participants_have_a_bar_each_from_the_same_column() -> None:
    first, second = drawn(GoalBar(TIME, 400, 1000, "Ana"), GoalBar(TIME, 700, 1000, "P02"))
    assert first.startswith("Ana ━")
    assert second.startswith("P02 ━")


def test_a_narrow_window_has_no_bar() -> None:
    assert drawn(GoalBar(TIME, 400, 1000), width=30) == []


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

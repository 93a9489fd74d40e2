"""A correction needs a decline that is more than a person's own noise, in two attempts, against a
baseline.
"""

from itertools import pairwise

import pytest

from sar_tui.rules.decline import EACH, LEAST_BASELINE, LONGEST_BASELINE, decline

BASELINE = (20.0, 21.0, 19.0, 20.0, 22.0, 18.0, 20.5, 19.5)


@pytest.mark.parametrize("better", ["lower", "higher"])
def test_two_attempts_that_are_much_worse_are_a_decline(better: str) -> None:
    sign = 1.0 if better == "lower" else -1.0
    found = decline([*BASELINE, 20 + sign * 10, 20 + sign * 12], better)  # type: ignore[arg-type]
    assert found
    assert (found.usual, found.by) == (20.0, sign * 11)
    assert 0 < found.mdc95 < 11
    assert decline([*BASELINE, 20 - sign * 10, 20 - sign * 12], better) is None  # type: ignore[arg-type]


@pytest.mark.parametrize("recent", [(19.0, 60.0), (60.0, 20.5), (20.0, 20.0)])
def test_one_spoilt_attempt_is_none(recent: tuple[float, float]) -> None:
    assert decline([*BASELINE, *recent], "lower") is None


@pytest.mark.parametrize("count", range(LEAST_BASELINE + 2))
def test_without_a_baseline_there_is_none(count: int) -> None:
    values = [*[20.0, 21.0] * 20][: max(0, count - 2)]
    assert decline([*values, *[500.0, 500.0][: count - len(values)]], "lower") is None


def test_a_decline_of_less_than_the_margin_is_none_however_steady_the_person_is() -> None:
    values = [*[10.0] * LEAST_BASELINE, 11.0, 11.5]
    assert decline(values, "lower", least=2.0) is None
    found = decline(values, "lower", least=1.0)
    assert found
    assert (found.by, found.mdc95, found.size) == (1.25, 0.0, float("inf"))


def test_what_is_judged_with_others_must_be_the_larger() -> None:
    sizes = [size / 10 for size in range(10, 100)]
    least = [
        next(
            size
            for size in sizes
            if decline([*BASELINE, 20 + size, 20 + size], "lower", measures=measures)
        )
        for measures in (1, 2, 4, 8)
    ]
    assert all(less < more for less, more in pairwise(least))
    assert least[0] > EACH


def test_what_was_long_ago_does_not_count() -> None:
    recent = [20.0, 21.0] * (LONGEST_BASELINE // 2)
    assert decline([*[500.0, 0.0] * 10, *recent, 30.0, 31.0], "lower") == decline(
        [*recent, 30.0, 31.0], "lower"
    )

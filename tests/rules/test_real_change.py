"""A change counts as real if it exceeds the noise of the person's own last attempts."""

import math
from statistics import stdev
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.rules.real_change import LATEST, LEAST_ATTEMPTS, Sample, judge
from sar_tui.rules.student import quantile, t95, within


@pytest.mark.parametrize("df", [1, 2, 3, 4, 5, 9, 18, 19, 60, 198, 399])
def test_student_t_is_scipys(df: int, stats: Any) -> None:
    assert t95(df) == pytest.approx(stats.t.ppf(0.975, df), abs=1e-9)
    assert quantile(df, 0.98) == pytest.approx(stats.t.ppf(0.99, df), abs=1e-9)
    assert within(1.3, df) == pytest.approx(1 - 2 * stats.t.sf(1.3, df), abs=1e-9)


VALUES = st.floats(-1e3, 1e3).map(lambda value: round(value, 3))


def attempts(*means: float, n: int = 4, sd: float = 1.0) -> list[Sample]:
    return [Sample(mean, n, sd) for mean in means]


def test_the_margin_is_the_mdc95_of_the_larger_noise() -> None:
    alike = judge(Sample(3.0, 4, 1.0), Sample(0.0, 4, 1.0), attempts(0.0, 0.0, 0.0), "higher")
    assert alike is not None
    assert alike.mdc95 == pytest.approx(t95(11) * math.sqrt(2) * 1.0 / math.sqrt(4)), (
        "from the trials"
    )
    apart = judge(Sample(3.0, 4, 1.0), Sample(2.0, 4, 1.0), attempts(-2.0, 0.0, 2.0), "higher")
    assert apart is not None
    assert apart.mdc95 == pytest.approx(t95(11) * math.sqrt(2) * 2.0), "between the attempts"


def test_many_attempts_give_the_published_factor() -> None:
    many = attempts(*[-1.0, 1.0] * 5, n=50, sd=0.0)
    change = judge(Sample(0.0, 50), many[-1], many, "higher")
    assert change is not None
    assert change.mdc95 == pytest.approx(1.96 * math.sqrt(2) * stdev([-1.0, 1.0] * 5), rel=0.01)


@pytest.mark.parametrize(("better", "verdict"), [("higher", "better"), ("lower", "worse")])
def test_the_direction_says_which_change_is_better(better: str, verdict: str) -> None:
    change = judge(Sample(9.0, 4, 1.0), Sample(0.0, 4, 1.0), attempts(0.1, -0.1, 0.0), better)  # type: ignore[arg-type]
    assert change is not None
    assert (change.by, change.verdict) == (9.0, verdict)


@pytest.mark.parametrize(
    "earlier",
    [attempts(), attempts(0.0, 0.1), attempts(*[0.0] * 4, n=1, sd=0.0)],
    ids=["none", "two", "four trials"],
)
def test_too_few_attempts_or_trials_judge_nothing(earlier: list[Sample]) -> None:
    assert judge(Sample(99.0), Sample(0.0), earlier, "higher") is None


def test_a_change_below_what_is_worth_a_word_is_none() -> None:
    steady = attempts(*[2.0] * 5, sd=0.0)
    for now, verdict in ((2.9, "chance"), (3.0, "better"), (2.0, "chance")):
        change = judge(Sample(now, 4), steady[-1], steady, "higher", least=1.0)
        assert change is not None
        assert change.verdict == verdict


def test_attempts_that_are_all_alike_make_no_change_of_a_rounding_error() -> None:
    alike = attempts(*[0.3] * 5, sd=0.0)
    change = judge(Sample(0.1 + 0.2, 4), alike[-1], alike, "higher")
    assert change is not None
    assert change.verdict == "chance"


def test_an_outlier_as_reference_earns_no_praise() -> None:
    """The attempt after one bad attempt is better than that one by chance."""
    for earlier in range(LEAST_ATTEMPTS, LATEST + 1):
        before = attempts(*[0.1, -0.1] * earlier, sd=0.3)[: earlier - 1] + attempts(-20.0, sd=0.3)
        change = judge(Sample(0.0, 4, 0.3), before[-1], before, "higher", measures=3)
        assert change is not None
        assert change.verdict == "chance", earlier


def test_only_the_last_attempts_tell_todays_noise() -> None:
    noisy, steady = attempts(*[-50.0, 50.0] * 10), attempts(*[0.1, -0.1] * 5)
    change = judge(Sample(5.0, 4, 1.0), steady[-1], [*noisy, *steady], "higher")
    assert change is not None
    assert change.verdict == "better"


@given(
    st.lists(VALUES, min_size=3, max_size=12),
    VALUES,
    st.integers(1, 6),
    st.floats(0, 100),
    st.floats(0.01, 100),
)
def test_the_verdict_does_not_depend_on_the_unit_or_its_direction(
    means: list[float], now: float, n: int, sd: float, factor: float
) -> None:
    earlier, present = attempts(*means, n=n, sd=sd), Sample(now, n, sd)
    one = judge(present, earlier[-1], earlier, "higher")
    other = [Sample(-factor * each.mean, n, factor * sd) for each in [*earlier, present]]
    turned = judge(other[-1], other[-2], other[:-1], "lower")
    assert (one is None) == (turned is None)
    if one and turned:
        assert turned.mdc95 == pytest.approx(factor * one.mdc95)
        if abs(abs(one.by) - one.mdc95) > 1e-6 * max(1.0, *map(abs, [*means, now])):
            assert one.verdict == turned.verdict


@given(st.lists(VALUES, min_size=5, max_size=10), VALUES)
def test_what_is_judged_with_others_needs_no_smaller_change(means: list[float], now: float) -> None:
    earlier = attempts(*means)
    found = [
        judge(Sample(now, 4, 1.0), earlier[-1], earlier, "higher", measures=count)
        for count in (1, 3, 6)
    ]
    verdicts = [change.verdict for change in found if change]
    assert verdicts in (
        ["chance"] * 3,
        [verdicts[0]] * 3,
        [verdicts[0], "chance", "chance"],
        [*verdicts[:2], "chance"],
    )

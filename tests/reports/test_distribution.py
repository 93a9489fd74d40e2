"""Statistics and histograms of times."""

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from sar_tui.reports.distribution import BINS, Distribution, bins, distribution, histogram

TIMES = st.lists(
    st.integers(-1_000_000, 60_000_000).map(lambda us: us / 1000), min_size=1, max_size=50
)


def test_statistics_computed_by_hand() -> None:
    """For 0, 10, … 200 the percentile q is 2q."""
    assert distribution([10 * n for n in range(21)]) == Distribution(
        n=21, median=100, iqr=100, p5=10, p25=50, p75=150, p95=190, worst=200
    )
    assert distribution([100, 200]) == Distribution(
        n=2, median=150, iqr=50, p5=105, p25=125, p75=175, p95=195, worst=200
    )
    assert distribution([7.5]) == Distribution(
        n=1, median=7.5, iqr=0, p5=7.5, p25=7.5, p75=7.5, p95=7.5, worst=7.5
    )
    assert distribution([]) is None


@given(TIMES)
def test_percentiles_are_in_order(times: list[float]) -> None:
    found = distribution(times)
    assert found is not None
    figures = [min(times), found.p5, found.p25, found.median, found.p75, found.p95, found.worst]
    assert all(low <= high + 0.001 for low, high in pairwise(figures))
    assert found.worst == max(times)


@given(TIMES, st.integers(30, 100))
def test_every_time_is_in_the_bin_that_holds_it_and_has_a_bar(
    times: list[float], width: int
) -> None:
    found = bins(times)
    assert len(found) <= BINS
    assert [each.n for each in found] == [
        sum(each.low <= time < each.high for time in times) for each in found
    ]
    assert sum(each.n for each in found) == len(times)
    assert all(one.high == other.low for one, other in pairwise(found))
    for line, each in zip(histogram(times, width), found, strict=True):
        assert len(line) <= width
        assert ("█" in line) == bool(each.n)


def test_bins_have_a_round_width_and_include_empty_ones() -> None:
    found = bins([120, 340, 360, 2210])
    assert [(each.low, each.high) for each in found] == [(n, n + 200) for n in range(0, 2400, 200)]
    assert [each.n for each in found] == [1, 2, *[0] * 9, 1]


def test_bars_are_proportional_to_counts() -> None:
    assert histogram([10.5] * 2 + [11.5, 13.5], 40) == [
        "10–11 ms ████████ 2",
        "11–12 ms ████ 1",
        "12–13 ms  0",
        "13–14 ms ████ 1",
    ]
    (line,) = histogram([10.5] * 500, 40)
    assert line == f"10–11 ms {'█' * 26} 500"
    assert histogram([], 40) == []

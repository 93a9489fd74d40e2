"""Scores of other instruments beside their published changes."""

import pytest

from sar_tui.progress.instruments import INSTRUMENTS, InstrumentChange, Score, changes


def scored(name: str, *scores: float) -> InstrumentChange:
    (found,) = changes([Score(name, f"2026-03-{day:02}", score) for day, score in enumerate(scores, 1)])
    return found


def kinds(found: InstrumentChange) -> list[tuple[str, bool]]:
    return [(each.published.kind, each.reached) for each in found.reached]


def test_one_score_has_no_change() -> None:
    found = scored("FMA-UE", 34)
    assert (found.change, found.reached) == (None, [])


@pytest.mark.parametrize(
    ("last", "reached"),
    [
        (40, [("MDC", False), ("MCID", False), ("MCID", False)]),
        (41, [("MDC", True), ("MCID", False), ("MCID", False)]),
        (43, [("MDC", True), ("MCID", True), ("MCID", True)]),
        (24, [("MDC", True), ("MCID", False), ("MCID", False)]),
    ],
)
def test_a_change_is_compared_with_what_is_published(last: float, reached: list[tuple[str, bool]]) -> None:
    assert kinds(scored("FMA-UE", 34, 60, last)) == reached


def test_less_pain_is_an_improvement() -> None:
    assert kinds(scored("NRS", 7, 5)) == [("MDC", True), ("MCID", True)]
    assert kinds(scored("NRS", 5, 7)) == [("MDC", True), ("MCID", False)]


@pytest.mark.parametrize("name", ["WMFT-TIME", "GAS"])
def test_where_nothing_is_published_nothing_is_compared(name: str) -> None:
    assert scored(name, 0, 2).reached == []


def test_every_published_value_names_its_people_and_its_source() -> None:
    values = [(each, instrument) for instrument in INSTRUMENTS.values() for each in instrument.published]
    assert all(each.of and each.source and 0 < each.low <= each.high for each, _ in values)
    assert not [instrument.name for each, instrument in values if instrument.unit in ("ms", "s")]

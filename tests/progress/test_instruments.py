"""Scores of other instruments beside their published changes."""

from pathlib import Path

import pytest

from sar_tui.progress.instruments import INSTRUMENTS, InstrumentChange, Score, changes


def scored(name: str, *scores: float) -> InstrumentChange:
    (found,) = changes(
        [Score(name, f"2026-03-{day:02}", score) for day, score in enumerate(scores, 1)]
    )
    return found


def kinds(found: InstrumentChange) -> list[tuple[str, bool]]:
    return [(each.published.kind, each.reached) for each in found.reached]


def test_one_score_has_no_change() -> None:
    found = scored("FMA-UE", 34)
    assert (found.change, found.reached) == (None, [])


@pytest.mark.parametrize(
    ("last", "reached"),
    [
        (38, [False, False, False, False, False]),
        (40, [False, False, False, False, True]),
        (41, [True, False, False, True, True]),
        (43, [True, True, True, True, True]),
        (24, [True, False, False, True, False]),
    ],
)
def test_a_change_is_compared_with_what_is_published(last: float, reached: list[bool]) -> None:
    assert [found for _, found in kinds(scored("FMA-UE", 34, 60, last))] == reached


def test_less_time_is_an_improvement_and_a_detectable_change_may_be_larger_than_an_important_one() -> (
    None
):
    assert kinds(scored("WMFT-TIME", 20, 17)) == [("MDC90", False), ("MCID", True)]
    assert kinds(scored("WMFT-TIME", 20, 25)) == [("MDC90", True), ("MCID", False)]


def test_less_pain_is_an_improvement() -> None:
    assert kinds(scored("NRS", 7, 5)) == [("MDC", True), ("MCID", True)]
    assert kinds(scored("NRS", 5, 7)) == [("MDC", True), ("MCID", False)]


def test_where_nothing_is_published_nothing_is_compared() -> None:
    assert scored("GAS", 0, 2).reached == []


def test_every_published_value_names_its_people_and_its_source() -> None:
    values = [
        (each, instrument) for instrument in INSTRUMENTS.values() for each in instrument.published
    ]
    assert all(
        each.of and "doi:10." in each.source and 0 < each.low <= each.high for each, _ in values
    )
    pages = (Path(__file__).parents[2] / "docs" / "progress.md").read_text(encoding="utf-8")
    assert [
        each.source for each, _ in values if each.source.partition("doi:")[2] not in pages
    ] == []


def test_values_for_severe_and_for_chronic_impairment_are_told_apart() -> None:
    of = {each.of: (each.kind, each.low, each.high) for each in INSTRUMENTS["FMA-UE"].published}
    assert of["chronic stroke, minimal to moderate arm impairment"] == ("MCID", 4.25, 7.25)
    assert of["1 to 6 weeks after stroke, moderate to severe arm impairment"] == ("MCID", 9, 13)
    assert any(each.of.startswith("chronic stroke") for each in INSTRUMENTS["ARAT"].published)

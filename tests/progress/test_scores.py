"""Scores of other tests beside their published changes."""

from pathlib import Path

import pytest

from sar_tui.progress.scores import InstrumentChange, Score, changes
from sar_tui.records.kind import find, kinds


def scored(name: str, *scores: float) -> InstrumentChange:
    given = [Score("", name, f"2026-03-{day:02}", score) for day, score in enumerate(scores, 1)]
    (found,) = changes(kinds().values(), given)
    return found


def reached(found: InstrumentChange) -> list[tuple[str, bool]]:
    return [(each.published.kind, each.reached) for each in found.reached]


@pytest.mark.parametrize(
    ("last", "expected"),
    [
        (38, [False, False, False, False, False]),
        (40, [False, False, False, False, True]),
        (41, [True, False, False, True, True]),
        (43, [True, True, True, True, True]),
        (24, [True, False, False, True, False]),
    ],
)
def test_a_change_is_compared_with_what_is_published(last: float, expected: list[bool]) -> None:
    assert [each for _, each in reached(scored("FMA-UE", 34, 60, last))] == expected


@pytest.mark.parametrize(
    ("name", "first", "last", "expected"),
    [
        ("WMFT-TIME", 20, 17, [("MDC90", False), ("MCID", True)]),
        ("WMFT-TIME", 20, 25, [("MDC90", True), ("MCID", False)]),
        ("NRS", 7, 5, [("MDC", True), ("MCID", True)]),
        ("NRS", 5, 7, [("MDC", True), ("MCID", False)]),
        ("GAS", 0, 2, []),
    ],
)
def test_an_improvement_may_be_a_smaller_score_and_an_mdc_holds_both_ways(
    name: str, first: float, last: float, expected: list[tuple[str, bool]]
) -> None:
    assert reached(scored(name, first, last)) == expected
    alone = scored(name, first)
    assert (alone.change, alone.reached) == (None, [])


def test_every_published_value_names_its_people_and_its_source() -> None:
    values = [each for kind in kinds().values() for each in kind.published]
    assert values
    assert all(
        each.of and "doi:10." in each.source and 0 < each.low <= each.high for each in values
    )
    pages = (Path(__file__).parents[2] / "docs" / "progress.md").read_text(encoding="utf-8")
    assert [each.source for each in values if each.source.partition("doi:")[2] not in pages] == []


def test_values_for_severe_and_for_chronic_impairment_are_told_apart() -> None:
    of = {each.of: (each.kind, each.low, each.high) for each in find("FMA-UE").published}
    assert of["chronic stroke, minimal to moderate arm impairment"] == ("MCID", 4.25, 7.25)
    assert of["1 to 6 weeks after stroke, moderate to severe arm impairment"] == ("MCID", 9, 13)
    assert any(each.of.startswith("chronic stroke") for each in find("ARAT").published)

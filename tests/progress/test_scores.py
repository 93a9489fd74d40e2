"""Scores of other tests beside their published changes."""

import re
from pathlib import Path

import pytest

from sar_tui.progress.scores import InstrumentChange, Score, changes
from sar_tui.records.kind import Kind, Published, find, kinds
from sar_tui.reports.progress_words import published


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
    for each in values:
        assert re.search(r"\d+ (people|inpatients)", each.of)
        assert re.search(r"\d{4}, .*(doi:10\.|DOI not found)", each.source)
        assert each.method
        assert each.interval
        assert 0 < each.low <= each.high


def test_the_table_of_the_documentation_has_the_published_values() -> None:
    page = (Path(__file__).parents[2] / "docs" / "progress.md").read_text(encoding="utf-8")
    section = page.partition("## Other instruments")[2].partition("\n## ")[0]
    rows = [line for line in section.splitlines() if line.startswith("|")][2:]
    assert rows == [row(kind, each) for kind in kinds().values() for each in kind.published]


def test_what_a_source_does_not_tell_is_said_to_be_not_found() -> None:
    own = Published("MDC", 3, 3, "12 people, our own clinic", "Our own clinic, 2026")
    assert published(own, find("ARAT")) == (
        "MDC 3 points, 12 people, our own clinic; method: not found; interval: not found "
        "(Our own clinic, 2026)"
    )


def row(kind: Kind, value: Published) -> str:
    """Return a published change as a row of the table in docs/progress.md."""
    assert kind.score
    size = f"{value.low:g}" if value.low == value.high else f"{value.low:g} to {value.high:g}"
    change = f"{value.kind} {size} {kind.score.unit}"
    cells = (kind.name, change, value.of, value.method, value.interval, value.source)
    assert value.read == "abstract", "the page says so of all"
    return f"| {' | '.join(cells)} |"


def test_values_for_severe_and_for_chronic_impairment_are_told_apart() -> None:
    of = {each.of: (each.kind, each.low, each.high) for each in find("FMA-UE").published}
    (chronic,) = (value for people, value in of.items() if "minimal to moderate arm" in people)
    (early,) = (value for people, value in of.items() if "moderate to severe arm" in people)
    assert (chronic, early) == (("MCID", 4.25, 7.25), ("MCID", 9, 13))
    assert any("chronic stroke" in each.of for each in find("ARAT").published)

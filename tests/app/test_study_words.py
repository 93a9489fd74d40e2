"""The sentences on what is due in a study."""

from datetime import date

import msgspec
import pytest

from sar_tui.app.study.words import about, card_words, cell_words, deviations, sentence
from sar_tui.model.language import ENGLISH
from sar_tui.study.ledger import Differed
from sar_tui.study.schedule import Item, Next, State, VisitDay
from sar_tui.study.status import NextPlace, PersonRow, VisitCell
from tests.study.plans import plan

PLAN = plan()
TODAY = date(2026, 3, 2)
FIRST, SECOND = PLAN.visits


def cell(state: State, first: date | None = None, last: date | None = None) -> VisitCell:
    return VisitCell(state=state, first=first, last=last, days=(), done=0, of=1, deviated=False)


def row(who: str, second: VisitCell, visit: int = 2) -> PersonRow:
    """A person who has done the first visit."""
    return PersonRow(
        participant=who,
        number=1,
        group="",
        stratum="",
        visits={"first": cell("done"), "second": second},
        deviations=0,
        ended="",
        next=NextPlace(visit=visit, block=1) if visit else None,
    )


DUE = cell("due", date(2026, 2, 28), date(2026, 3, 4))
LATE = cell("late", date(2026, 2, 20), date(2026, 2, 24))
EARLY = cell("early", date(2026, 3, 5), date(2026, 3, 9))


@pytest.mark.parametrize(
    ("cells", "said"),
    [
        ([], "Nobody is enrolled yet."),
        ([DUE], "1 person is due today."),
        ([DUE, DUE, LATE], "2 people are due today. 1 visit is late."),
        ([LATE, LATE, EARLY], "2 visits are late."),
        ([EARLY], "Nobody is due today. The next one is P00, from Thu 5 Mar."),
    ],
)
def test_the_sentence_counts_who_is_due(cells: list[VisitCell], said: str) -> None:
    rows = [row(f"P{number:02}", each) for number, each in enumerate(cells)]
    assert sentence(PLAN, rows, TODAY, ENGLISH) == said


def test_whoever_is_in_a_session_is_named_and_not_counted_as_due() -> None:
    playing = msgspec.structs.replace(DUE, playing=True)
    said = sentence(PLAN, [row("P01", playing), row("P02", DUE)], TODAY, ENGLISH)
    assert said == "P01 is in a session now. 1 person is due today."
    assert cell_words(playing, TODAY, ENGLISH) == "in a session now"


def test_the_sentence_tells_the_end_of_a_study() -> None:
    rows = [row("P01", cell("done"), visit=0)]
    assert sentence(PLAN, rows, TODAY, ENGLISH) == "Nobody has anything more to do."
    assert card_words(PLAN, rows[0], TODAY, ENGLISH) == ""


@pytest.mark.parametrize(
    ("second", "state"),
    [(DUE, "due by 4 Mar"), (LATE, "late"), (EARLY, "from 5 Mar"), (cell("due"), "due")],
)
def test_the_card_says_the_state_of_the_next_visit(second: VisitCell, state: str) -> None:
    said = card_words(PLAN, row("P01", second), TODAY, ENGLISH)
    assert said == f"Study praise: visit 2, block 1, {state}. F7"


def test_what_happened_before_a_block_is_told() -> None:
    day = VisitDay(visit=SECOND, state="due", first=TODAY, last=TODAY, days=(), done=0, of=1)
    item = Item(visit=SECOND, block=SECOND.blocks[0], condition="praised")
    found = Next(item=item, day=day, repeats=True, passed=(FIRST,))
    assert about("P01", found, TODAY, ENGLISH) == (
        "The visit first was missed. The visit “second” of P01 is today. "
        "A session was cut off: the block begins again."
    )


def test_a_visit_whose_last_day_is_today_is_due_today() -> None:
    assert cell_words(cell("due", TODAY, TODAY), TODAY, ENGLISH) == "due today"


def test_deviations_that_are_alike_are_told_once() -> None:
    early = Differed(
        participant="P01", visit="only", block="b", what="ended early", reason="", at=""
    )
    late = msgspec.structs.replace(early, what="late", reason="Bus")
    assert deviations([early, late, early], ENGLISH) == (
        "Differs from the plan: only: ended early × 2, only: late (Bus)."
    )

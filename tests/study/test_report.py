"""The status of people and the report on a study: consent, blocks done in part, and levels that were
changed by hand.
"""

from collections.abc import Iterator
from contextlib import closing
from datetime import timedelta
from pathlib import Path

import pytest

from sar_tui.loop.topics import LEVEL
from sar_tui.store import records
from sar_tui.store.database import StoreError
from sar_tui.study import enrolment, ledger
from sar_tui.study.report import make_report, sections
from sar_tui.study.status import PersonRow, grid
from tests.store.by_hand import add_message
from tests.study.plans import TWO_GROUPS
from tests.study.test_next_block import CONSENT, NOW, Rehearsed

FIXED = TWO_GROUPS.replace("prompts_per", 'difficulty_policy = "fixed", prompts_per')


@pytest.fixture
def study(tmp_path: Path) -> Iterator[Rehearsed]:
    found = Rehearsed(tmp_path, CONSENT)
    with closing(found.db):
        yield found


def row_of(study: Rehearsed) -> PersonRow:
    (row,) = grid(study.frozen, ledger.people(study.db, study.frozen), study.key, NOW)
    return row


def answer(study: Rehearsed, said: str) -> None:
    content = {"study": "praise", "version": "2", "answer": said}
    records.add(study.db, records.kind_of(ledger.CONSENT), "P01", "", content)


@pytest.mark.parametrize(("said", "ended"), [("no", "no consent"), ("withdrawn", "withdrawn")])
def test_nothing_is_due_to_whoever_does_not_agree_or_agrees_no_longer(
    study: Rehearsed, said: str, ended: str
) -> None:
    answer(study, said)
    row = row_of(study)
    assert (row.ended, row.next) == (ended, None)
    assert [cell.words for cell in row.visits.values()] == ["", ""]
    report = make_report(study.db, study.frozen, study.key, NOW)
    assert [flow.ended for flow in report.groups] == [{ended: 1}]
    with pytest.raises(StoreError, match="still takes part: end it first"):
        enrolment.enrol(study.db, study.frozen, "P02", study.key, replaces="P01")
    answer(study, "yes")
    assert (row_of(study).ended, row_of(study).visits["first"].words) == ("", "due")


def test_a_block_ended_before_its_first_attempt_is_due_again(study: Rehearsed) -> None:
    id = study.play()
    study.db.execute("UPDATE sessions SET status='aborted' WHERE id=?", (id,))
    study.db.execute("DELETE FROM attempts WHERE session=?", (id,))
    found = study.due()[1]
    assert (found.item.block.name, found.repeats) == ("baseline", False)
    study.play()
    assert study.due()[1].item.block.name == "speeds"
    ((differed,),) = (each.deviations for each in ledger.people(study.db, study.frozen))
    assert differed.what == "ended early"


def test_a_block_with_fewer_attempts_than_planned_is_listed_as_missing(study: Rehearsed) -> None:
    id = study.play()
    study.db.execute("DELETE FROM attempts WHERE session=? AND attempt>1", (id,))
    report = make_report(study.db, study.frozen, study.key, NOW)
    assert "first/baseline" not in report.missing
    (short,) = report.short
    assert (short.participant, short.block, short.attempts, short.of) == ("P01", "baseline", 1, 3)
    assert "Missing data" in [section.title for section in sections(report)]


def test_a_level_that_the_plan_fixes_and_somebody_changes_is_a_deviation(tmp_path: Path) -> None:
    study = Rehearsed(tmp_path, FIXED)
    with closing(study.db):
        untouched, id = study.play(), study.play(NOW + timedelta(hours=1))
        study.db.execute(
            "UPDATE attempts SET level=level+1 WHERE session IN (?, ?) AND attempt>1",
            (untouched, id),
        )
        assert row_of(study).deviations == 0
        said = {"previous": 1, "level": 2, "reason": "operator"}
        add_message(study.db, id, 10**6, 0, LEVEL.name, said)
        (one,) = ledger.people(study.db, study.frozen)
    assert [(each.block, each.what) for each in one.deviations] == [
        ("speeds", "level changed by hand")
    ]

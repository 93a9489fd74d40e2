"""A block begins with the condition, the level and the order of its person, and not without
consent.
"""

from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path
from sqlite3 import Connection

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import locks, programmes, records, sessions
from sar_tui.store.database import StoreError, connect
from sar_tui.store.integrity import flaws
from sar_tui.store.programmes import Programme
from sar_tui.study import enrolment, ledger, next_block
from sar_tui.study.next_block import NeedsReason, Person, due, person, plan_of
from sar_tui.study.report import make_report
from sar_tui.study.schedule import Next
from sar_tui.study.status import grid
from tests.study.plans import TWO_GROUPS, plan

NOW = datetime(2026, 3, 2, 12, tzinfo=UTC)
CATALOGUE = Catalogue(())
CONSENT = TWO_GROUPS.replace("[outcome]", '[consent]\nversion = "2"\n\n[outcome]')


class Rehearsed:
    """A study in a rehearsal, with one person."""

    def __init__(
        self, folder: Path, text: str = TWO_GROUPS, mode: ledger.Mode = "simulated"
    ) -> None:
        self.folder, self.key = folder / "data", folder / "praise.key"
        self.db: Connection = connect(self.folder)
        enrolment.freeze(self.db, CATALOGUE, text, plan(text), self.key, mode=mode, author="me")
        self.frozen = ledger.find(self.db)
        enrolment.enrol(self.db, self.frozen, "P01", self.key, now=NOW)

    def due(self, now: datetime = NOW, **wanted: str) -> tuple[Person, Next]:
        one = person(self.db, self.frozen, "P01", self.key)
        return one, due(self.db, one, now, **wanted)

    def play(self, now: datetime = NOW, **wanted: str) -> str:
        one, found = self.due(now, **wanted)
        next_block.note_deviations(
            self.db, one, found, wanted.get("reason", ""), author="me", now=now
        )
        session = plan_of(self.db, CATALOGUE, one, found, seed=1)
        return simulate(session, PEOPLE["average"], self.folder, CATALOGUE, began=now)

    def group(self) -> str:
        return ledger.enrolment(self.db, "praise", "P01").group

    def deviations(self) -> list[tuple[object, ...]]:
        return [
            (each.content.get("visit"), each.content.get("block"), each.content["what"],
             each.content.get("reason"))
            for each in ledger.of_study(self.db, ledger.DEVIATION, "praise")
        ]  # fmt: skip


@pytest.fixture
def study(tmp_path: Path) -> Iterator[Rehearsed]:
    found = Rehearsed(tmp_path)
    with closing(found.db):
        yield found


def test_each_block_names_its_place_and_has_its_own_setting(study: Rehearsed) -> None:
    ids = [study.play(NOW + timedelta(hours=hour)) for hour in range(3)]
    ids.append(study.play(NOW + timedelta(days=7)))
    rows = [sessions.find(study.db, study.folder, id) for id in ids]
    places = [
        (row["study"]["visit"], row["study"]["block"], row["study"]["position"]) for row in rows
    ]
    assert places == [
        ("first", "baseline", 1), ("first", "speeds", 1), ("first", "speeds", 2),
        ("second", "training", 1),
    ]  # fmt: skip
    assert rows[0]["parameters"]["start_level"] == 3
    assert {row["study"]["condition"]: row["parameters"]["threshold"] for row in rows[1:3]} == {
        "slow": 1500,
        "fast": 800,
    }
    assert (
        rows[3]["study"]["condition"] == {"praise": "praised", "silent": "unpraised"}[study.group()]
    )
    last = [row["level"] for row in sessions.rows(study.db, "attempts", ids[0])][-1]
    assert rows[3]["parameters"]["start_level"] == last
    assert all(row["parameters"]["start_from"] == "fixed" for row in rows)
    with pytest.raises(StoreError, match="P01 has done all of the study praise"):
        study.due(NOW + timedelta(days=8))
    assert not [*flaws(study.db)]


def test_nothing_but_what_belongs_to_the_person_comes_from_the_programme(study: Rehearsed) -> None:
    own = {"threshold": 555, "start_level": 9, "language": "de", "bounce_ms": 120}
    programmes.save(study.db, "P01", "keyboard", Programme(own, "lively"), after=0)
    one, found = study.due()
    session = plan_of(study.db, CATALOGUE, one, found)
    assert (session.parameters.threshold, session.parameters.start_level) == (1000, 3)
    assert (session.parameters.language, session.parameters.bounce_ms) == ("de", 120)
    assert (session.theme, session.programme) == ("calm", None)


def test_a_visit_too_early_or_late_needs_a_reason_which_is_recorded(study: Rehearsed) -> None:
    for _ in range(3):
        study.play()
    for day, what in ((3, "early"), (30, "late")):
        with pytest.raises(NeedsReason, match=f"today is too {what}") as told:
            study.due(NOW + timedelta(days=day))
        assert told.value.what == what
    study.play(NOW + timedelta(days=3), reason="leaves for holidays")
    assert study.deviations() == [("second", None, "early", "leaves for holidays")]


def test_a_reason_for_the_day_holds_for_all_blocks_of_a_visit(tmp_path: Path) -> None:
    text = f'{TWO_GROUPS}[[visits.blocks]]\nname = "again"\ncondition = "unpraised"\n'
    study = Rehearsed(tmp_path, text)
    with closing(study.db):
        for _ in range(3):
            study.play()
        early = NOW + timedelta(days=3)
        study.play(early, reason="leaves for holidays")
        assert study.due(early)[1].item.block.name == "again"


def test_without_the_key_of_a_blind_study_the_states_of_visits_are_known(tmp_path: Path) -> None:
    study = Rehearsed(
        tmp_path, TWO_GROUPS.replace("[outcome]", "[allocation]\nblind = true\n[outcome]", 1)
    )
    with closing(study.db):
        study.play()
        people = ledger.people(study.db, study.frozen)
        shown = [grid(study.frozen, people, key, NOW) for key in (study.key, tmp_path / "none")]
    assert shown[0] == shown[1]
    assert shown[0][0].group in ("G1", "G2")


def test_a_block_out_of_order_or_done_again_needs_a_reason(study: Rehearsed) -> None:
    with pytest.raises(NeedsReason, match="is out of order"):
        study.due(visit="first", block="speeds")
    study.play(block="speeds", reason="the sensor was away")
    study.play()
    with pytest.raises(NeedsReason, match="is repeated"):
        study.due(block="baseline")
    study.play(block="baseline", reason="noise in the corridor")
    assert study.deviations() == [
        ("first", "speeds", "out of order", "the sensor was away"),
        ("first", "baseline", "repeated", "noise in the corridor"),
    ]
    with pytest.raises(StoreError, match="has no block nap"):
        study.due(block="nap", reason="?")


def test_each_difference_is_recorded_once(study: Rehearsed) -> None:
    study.play()
    early = NOW + timedelta(days=1)
    with pytest.raises(NeedsReason, match=r"is out of order\. .* today is too early"):
        study.due(early, visit="second")
    wanted = {"visit": "second", "reason": "only day"}
    for _ in range(2):  # the block is left, and begun again
        one, found = study.due(early, **wanted)
        next_block.note_deviations(study.db, one, found, "only day", author="me", now=early)
    study.play(early, **wanted)
    for reason in ("noise", "noise", "another noise"):
        study.play(early, visit="first", block="baseline", reason=reason)
    assert study.deviations() == [
        ("second", None, "early", "only day"),
        ("second", "training", "out of order", "only day"),
        ("first", None, "late", "noise"),
        ("first", "baseline", "repeated", "noise"),
        ("first", "baseline", "repeated", "another noise"),
    ]


def test_the_next_block_by_its_name_is_in_order_and_its_day_may_differ(study: Rehearsed) -> None:
    for _ in range(3):
        study.play()
    early = NOW + timedelta(days=3)
    with pytest.raises(NeedsReason, match="today is too early"):
        study.due(early, visit="second")
    study.play(early, visit="second", reason="leaves for holidays")
    assert study.deviations() == [("second", None, "early", "leaves for holidays")]


def test_a_condition_done_twice_makes_up_for_no_other(study: Rehearsed) -> None:
    for _ in range(2):
        study.play()
    study.play(block="baseline", reason="noise in the corridor")
    study.db.execute("UPDATE sessions SET study=json_set(study, '$.block', 'speeds')")
    study.db.execute("UPDATE sessions SET study=json_set(study, '$.position', 1)")
    content = {"what": "lost", "reason": "moved away"}
    ledger.note(study.db, ledger.EXIT, study.frozen.plan, "P01", content, author="me")
    report = make_report(study.db, study.frozen, study.key, NOW)
    assert report.missing == {"first/baseline": 1, "first/speeds": 1, "second/training": 1}


def test_a_reason_that_nothing_needs_is_no_deviation(study: Rehearsed) -> None:
    study.play(reason="as in the plan")
    assert study.deviations() == []


def test_a_session_whose_program_crashed_goes_on_by_any_name(study: Rehearsed) -> None:
    id = study.play()
    study.db.execute("UPDATE sessions SET status='running', ended_at=NULL")
    assert study.due()[1].resume == id
    assert study.due(visit="first")[1].resume == id
    _, again = study.due(NOW + timedelta(days=2), reason="?")
    assert (again.item.block.name, again.resume, again.repeats) == ("baseline", "", True)


def test_whoever_is_in_a_session_is_shown_and_begins_no_other(study: Rehearsed) -> None:
    id = study.play()
    study.db.execute("UPDATE sessions SET status='running', ended_at=NULL")
    held = locks.hold(study.folder, "session", id)
    try:
        with pytest.raises(StoreError, match="P01 is in a session now"):
            study.due()
        people = ledger.people(study.db, study.frozen)
        (row,) = grid(study.frozen, people, study.key, NOW)
        assert [cell.words for cell in row.visits.values()] == ["in a session now", ""]
    finally:
        held.release()


def test_a_level_is_carried_over_from_a_block_that_was_cut_off_and_left(tmp_path: Path) -> None:
    leaves = TWO_GROUPS.replace("[outcome]", '[interrupted]\nthen = "leave"\n[outcome]')
    study = Rehearsed(tmp_path, leaves)
    with closing(study.db):
        id = study.play()
        study.db.execute("UPDATE sessions SET status='interrupted'")
        later = NOW + timedelta(days=7)
        one, found = study.due(later, visit="second", reason="only day")
        last = [row["level"] for row in sessions.rows(study.db, "attempts", id)][-1]
        assert plan_of(study.db, CATALOGUE, one, found).parameters.start_level == last
        (differed,) = ledger.people(study.db, study.frozen)[0].deviations
        assert (differed.block, differed.what, differed.reason) == (
            "baseline", "ended early", "cut off",
        )  # fmt: skip


def test_a_level_that_is_to_be_carried_over_must_be_there(study: Rehearsed) -> None:
    one, found = study.due(visit="second", reason="only day")
    with pytest.raises(StoreError, match="the block first/baseline, which P01 has not done"):
        plan_of(study.db, CATALOGUE, one, found)


def test_whoever_has_left_begins_nothing(study: Rehearsed) -> None:
    content = {"what": "withdrawn", "reason": "too tired"}
    ledger.note(study.db, ledger.EXIT, study.frozen.plan, "P01", content, author="me")
    with pytest.raises(StoreError, match=r"takes part no longer: withdrawn \(too tired\)"):
        study.due()


def test_no_session_starts_without_the_consent_that_the_plan_asks_for(tmp_path: Path) -> None:
    study = Rehearsed(tmp_path, CONSENT, mode="live")

    def say(answer: str, version: str, on: str = "") -> None:
        content = {"study": "praise", "version": version, "answer": answer}
        records.add(study.db, records.kind_of(ledger.CONSENT), "P01", on, content)

    with pytest.raises(StoreError, match="has not agreed to the study praise yet"):
        study.due()
    say("yes", "1")
    with pytest.raises(
        StoreError, match="agreed to version 1 of the text; this plan needs version 2"
    ):
        study.due()
    say("yes", "2")
    say("no", "2", on="2026-01-05")  # entered later, of an earlier day
    assert study.due()[1].item.block.name == "baseline"
    say("withdrawn", "2")
    with pytest.raises(StoreError, match="has withdrawn the consent"):
        study.due()
    say("no", "2")
    with pytest.raises(StoreError, match="did not agree"):
        study.due()
    study.db.close()


def test_a_session_that_is_ended_early_is_done_and_a_deviation(study: Rehearsed) -> None:
    id = study.play()
    study.db.execute("UPDATE sessions SET status='aborted' WHERE id=?", (id,))
    _, found = study.due()
    assert found.item.block.name == "speeds"
    ((differed,),) = (each.deviations for each in ledger.people(study.db, study.frozen))
    assert (differed.block, differed.what) == ("baseline", "ended early")
    report = make_report(study.db, study.frozen, study.key, NOW)
    assert sum(flow.as_intended for flow in report.groups) == 0

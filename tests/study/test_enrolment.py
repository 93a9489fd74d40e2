"""A plan is frozen once, and a draw is neither lost nor done twice, whatever happens meanwhile."""

import random
import signal
import subprocess
import sys
import time
from collections import Counter
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.store import participants, people_events, records
from sar_tui.store.database import StoreError, connect
from sar_tui.store.erasure import de_identify, erase
from sar_tui.study import enrolment, ledger, secret
from sar_tui.study.allocation import AllocationError, Assigned, ListedGroup, assign
from sar_tui.study.ledger import Frozen
from tests.study.plans import TWO_GROUPS, plan


class Place(NamedTuple):
    """A data folder with a frozen study, and the file of its key."""

    folder: Path
    key: Path


def freeze(place: Place, text: str = TWO_GROUPS, reason: str = "") -> Frozen:
    with closing(connect(place.folder)) as db:
        enrolment.freeze(
            db, Catalogue(()), text, plan(text), place.key, mode="live", author="me", reason=reason
        )
        return ledger.find(db)


@pytest.fixture
def place(tmp_path: Path) -> Place:
    found = Place(tmp_path / "data", tmp_path / "praise.key")
    freeze(found)
    return found


def people(place: Place) -> list[ledger.Enrolment]:
    with closing(connect(place.folder)) as db:
        return ledger.enrolments(db, "praise")


def check_draws(place: Place) -> None:
    """Check that the people of the ledger have consecutive numbers, and the groups of the key."""
    found = people(place)
    assert [one.number for one in found] == list(range(1, len(found) + 1))
    assert len({one.participant for one in found}) == len(found)
    draws, study, before = secret.read(place.key), plan(), list[Assigned]()
    weights = dict.fromkeys(study.groups, 1)
    for one in found:
        if one.replaces:
            continue
        group = assign(study.allocation, weights, draws, before, one.stratum)
        assert one.group == group
        before.append(Assigned(group=group, stratum=one.stratum))


def test_a_changed_plan_needs_a_new_version_and_a_reason(place: Place) -> None:
    freeze(place)  # the same again changes nothing
    changed = TWO_GROUPS.replace("attempts = 3", "attempts = 4", 1)
    with pytest.raises(
        StoreError, match="Version 1 of the study praise was frozen as another text"
    ):
        freeze(place, changed)
    newer = changed.replace('name = "praise"', 'name = "praise"\nversion = 2', 1)
    with pytest.raises(StoreError, match="needs a reason"):
        freeze(place, newer)
    frozen = freeze(place, newer, reason="too short")
    assert (frozen.plan.version, frozen.reason) == (2, "too short")
    with closing(connect(place.folder)) as db:
        assert [each.plan.version for each in ledger.versions(db, "praise")] == [1, 2]


def test_a_later_version_keeps_what_people_were_enrolled_with(place: Place) -> None:
    later = TWO_GROUPS.replace('name = "praise"', 'name = "praise"\nversion = 2', 1)
    coded = later.replace("[outcome]", "[allocation]\nblind = true\n[outcome]", 1)
    changes = {
        "keep the group silent": later.replace("groups.silent", "groups.quiet"),
        "have the same orders of conditions": later.replace('["slow", "fast"]', '["fast", "slow"]'),
        "have the same conditions, as their": coded.replace(
            "conditions.unpraised", "conditions.plain"
        ).replace('"unpraised"', '"plain"'),
    }
    with closing(connect(place.folder)) as db:
        enrolment.enrol(db, ledger.find(db), "P01", place.key)
    for said, text in changes.items():
        with pytest.raises(StoreError, match=f"version 2 must {said}"):
            freeze(place, text, reason="changed")
    assert freeze(place, later, reason="the same groups").plan.version == 2


def test_nobody_is_known_after_an_enrolment_that_failed(place: Place) -> None:
    with closing(connect(place.folder)) as db:
        frozen = ledger.find(db)
        with pytest.raises(StoreError, match="P09 is not in the study praise"):
            enrolment.enrol(db, frozen, "P01", place.key, replaces="P09")
        assert participants.codes(db) == []


def test_a_frozen_plan_has_each_setting_of_its_conditions(place: Place) -> None:
    import msgspec

    with closing(connect(place.folder)) as db:
        (text,) = db.execute("SELECT conditions FROM studies").fetchone()
    slow = msgspec.json.decode(text)["slow"]
    assert slow["parameters"]["threshold"] == 1500
    assert slow["parameters"]["attempts"] == 20
    assert slow["theme"] == "calm"


def test_the_key_of_another_study_is_refused(place: Place, tmp_path: Path) -> None:
    other = tmp_path / "other.key"
    secret.create(other)
    with closing(connect(place.folder)) as db:
        with pytest.raises(AllocationError, match="is not the key with which"):
            enrolment.enrol(db, ledger.find(db), "P01", other)
        with pytest.raises(AllocationError, match="copy it from the computer"):
            enrolment.enrol(db, ledger.find(db), "P01", tmp_path / "none.key")
    assert people(place) == []


def test_nobody_is_enrolled_twice(place: Place) -> None:
    with closing(connect(place.folder)) as db:
        frozen = ledger.find(db)
        enrolment.enrol(db, frozen, "P01", place.key)
        with pytest.raises(StoreError, match="P01 is in the study praise already, as number 1"):
            enrolment.enrol(db, frozen, "P01", place.key)
    assert len(people(place)) == 1


def test_whoever_replaces_a_person_gets_their_group_and_order(place: Place) -> None:
    with closing(connect(place.folder)) as db:
        frozen = ledger.find(db)
        first = enrolment.enrol(db, frozen, "P01", place.key)
        with pytest.raises(StoreError, match="P01 still takes part"):
            enrolment.enrol(db, frozen, "P02", place.key, replaces="P01")
        content = {"what": "lost", "reason": "moved away"}
        ledger.note(db, ledger.EXIT, frozen.plan, "P01", content, author="me")
        second = enrolment.enrol(db, frozen, "P02", place.key, replaces="P01")
        assert (second.group, second.orders) == (first.group, first.orders)
        with pytest.raises(StoreError, match="P01 was replaced by P02 already"):
            enrolment.enrol(db, frozen, "P03", place.key, replaces="P01")
        for number in range(3, 15):
            enrolment.enrol(db, frozen, f"P{number:02}", place.key)
    check_draws(place)


def test_a_factor_is_asked_for_and_orders_are_balanced_in_its_strata(tmp_path: Path) -> None:
    text = TWO_GROUPS.replace("[outcome]", '[allocation.strata]\nage = ["young", "old"]\n[outcome]')
    place = Place(tmp_path / "data", tmp_path / "praise.key")
    frozen = freeze(place, text)
    with closing(connect(place.folder)) as db:
        with pytest.raises(StoreError, match="The factor age is missing: add --factor age=young"):
            enrolment.enrol(db, frozen, "P01", place.key)
        with pytest.raises(StoreError, match="age is young or old, not 'middle'"):
            enrolment.enrol(db, frozen, "P01", place.key, factors={"age": "middle"})
        found = enrolment.enrol(db, frozen, "P01", place.key, factors={"age": "old"})
        assert found.stratum == "old"
        for number in range(2, 31):
            age = "young" if number % 3 else "old"
            enrolment.enrol(db, frozen, f"P{number:02}", place.key, factors={"age": age})
    orders = Counter((one.group, one.stratum, one.orders[0]) for one in people(place))
    for group in ("praise", "silent"):
        for age in ("young", "old"):
            assert abs(orders[group, age, 0] - orders[group, age, 1]) <= 1


def start(place: Place, prefix: str, number: int) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [
            sys.executable,
            "-m",
            "tests.study.enrolling",
            place.folder,
            place.key,
            prefix,
            str(number),
        ],
        stdout=subprocess.PIPE,
        text=True,
    )


def test_two_stations_that_draw_at_once_draw_nothing_twice(place: Place) -> None:
    stations = [start(place, prefix, 8) for prefix in "AB"]
    said = [line for each in stations for line in each.communicate()[0].splitlines()]
    assert len(said) == 16
    check_draws(place)


@pytest.mark.slow
def test_a_draw_that_is_cut_off_is_neither_lost_nor_done_twice(place: Place) -> None:
    """Killed at 100 moments: what was said is stored, and the next draw goes on after it."""
    moments = random.Random(3)
    told: list[str] = []
    for number in range(100):
        station = start(place, f"K{number}-", 50)
        assert station.stdout
        told.append(station.stdout.readline().strip())
        time.sleep(moments.uniform(0, 0.03))
        station.send_signal(signal.SIGKILL)
        told += [line for line in station.communicate()[0].splitlines() if " " in line]
    stored = {f"{one.participant} {one.group}" for one in people(place)}
    assert len(told) >= 100
    # the last line may be cut off within a word
    assert {line for line in told if line.split()[1] in ("praise", "silent")} <= stored
    check_draws(place)


def test_what_was_drawn_for_a_person_who_was_erased_stays_drawn_for_nobody(place: Place) -> None:
    with closing(connect(place.folder)) as db:
        frozen = ledger.find(db)
        first = [enrolment.enrol(db, frozen, code, place.key) for code in ("P01", "P02", "P03")]
    erase(place.folder, "P02", author="me", reason="asked for it")
    with closing(connect(place.folder)) as db:
        fourth = enrolment.enrol(db, ledger.find(db), "P04", place.key)
        found = ledger.enrolments(db, "praise")
    assert fourth.number == 4
    assert [one.group for one in found] == [one.group for one in (*first, fourth)]
    assert [one.ended for one in found] == ["", "erased", "", ""]
    assert found[1].participant != "P02"
    check_draws(place)


def test_whoever_withdrew_altogether_has_left_the_study(place: Place) -> None:
    with closing(connect(place.folder)) as db:
        enrolment.enrol(db, ledger.find(db), "P01", place.key)
        people_events.add(
            db, people_events.new_event("withdrawn", "P01", author="me", reason="too tired")
        )
        (one,) = ledger.enrolments(db, "praise")
    assert (one.ended, one.why_ended) == ("withdrawn", "too tired")


@pytest.mark.parametrize("how", ["erased", "de-identified"])
def test_the_code_of_a_person_who_was_replaced_goes_with_the_person(how: str, place: Place) -> None:
    with closing(connect(place.folder)) as db:
        frozen = ledger.find(db)
        enrolment.enrol(db, frozen, "FIRST", place.key)
        ledger.note(
            db, ledger.EXIT, frozen.plan, "FIRST", {"what": "lost", "reason": "moved"}, author="me"
        )
        second = enrolment.enrol(db, frozen, "SECOND", place.key, replaces="FIRST")
    if how == "erased":
        new = erase(place.folder, "FIRST", author="me", reason="").event.replaced_by
    else:
        new = de_identify(place.folder, "FIRST", author="me", reason="").event.participant
    first, found = people(place)
    assert (first.participant, found.replaces) == (new, new)
    assert (found.group, found.number) == (second.group, 2)
    de_identify(place.folder, "SECOND", author="me", reason="")
    assert people(place)[1].replaces == new


def test_a_person_who_is_de_identified_stays_in_the_study(place: Place) -> None:
    given = {"version": "2", "answer": "yes", "witness": "W01"}
    with closing(connect(place.folder)) as db:
        frozen = ledger.find(db)
        before = enrolment.enrol(db, frozen, "P01", place.key)
        ledger.note(db, ledger.CONSENT, frozen.plan, "P01", given, author="me")
    new = de_identify(place.folder, "P01", author="me", reason="").event.participant
    with closing(connect(place.folder)) as db:
        after = ledger.enrolment(db, "praise", new)
        assert (after.number, after.group, after.orders) == (1, before.group, before.orders)
        consent = ledger.consent_of(db, "praise", new)
        assert consent
        assert (consent.content["version"], consent.content["witness"]) == ("2", "")
        people_events.add(db, people_events.new_event("withdrawn", new, author="me", reason=""))
    newer = de_identify(place.folder, new, author="me", reason="").event.participant
    (left,) = people(place)
    assert (left.participant, left.ended) == (newer, "withdrawn")


def test_whoever_was_given_another_code_stays_in_the_study(place: Place) -> None:
    with closing(connect(place.folder)) as db:
        frozen = ledger.find(db)
        for code in ("P01", "P02"):
            enrolment.enrol(db, frozen, code, place.key)
        content = {"what": "lost", "reason": "moved to Thun"}
        ledger.note(db, ledger.EXIT, frozen.plan, "P01", content, author="me")
        enrolment.enrol(db, frozen, "P03", place.key, replaces="P01")
        event = people_events.new_event("withdrawn", "P02", author="me", reason="tired of it")
        people_events.add(db, event)
    before = people(place)
    new = [
        de_identify(place.folder, code, author="me", reason="end").event.participant
        for code in ("P01", "P02")
    ]
    after = people(place)
    assert [(one.number, one.group, one.orders) for one in after] == [
        (one.number, one.group, one.orders) for one in before
    ]
    assert [one.participant for one in after] == [*new, "P03"]
    assert [one.ended for one in after] == ["lost", "withdrawn", ""]
    assert after[2].replaces == new[0]
    with closing(connect(place.folder)) as db:
        stored = "".join(text for (text,) in db.execute("SELECT content FROM records"))
        assert enrolment.enrol(db, frozen, "P04", place.key).number == 4
    assert "Thun" not in stored
    assert "P01" not in stored


def test_nobody_changes_or_removes_an_enrolment(place: Place) -> None:
    with closing(connect(place.folder)) as db:
        enrolment.enrol(db, ledger.find(db), "P01", place.key)
        for given, removed in (({"group": "silent"}, False), ({}, True)):
            with pytest.raises(StoreError, match="praise-1 is part of the ledger of a study"):
                records.correct(db, "praise-1", given, removed=removed)


def test_a_list_names_groups_of_the_plan_only(tmp_path: Path) -> None:
    listed = tmp_path / "list.csv"
    listed.write_text("group,stratum\npraise,BERN\nplacebo,BERN\n")
    with pytest.raises(AllocationError, match=r"line 3: the group is one of .*, not 'placebo'"):
        secret.read_list(listed, ("praise", "silent"))
    listed.write_text("group,stratum\npraise, BERN\n")
    assert secret.read_list(listed, ("praise",)) == (ListedGroup("praise", "BERN"),)

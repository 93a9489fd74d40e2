"""Erased, de-identified, moved and withdrawn: it is so in every database, whatever the order."""

from contextlib import closing
from itertools import permutations
from pathlib import Path

import pytest

from sar_tui.store import participants, people_events, record_changes
from sar_tui.store.database import connect
from sar_tui.store.erasure import de_identify, erase
from sar_tui.store.integrity import flaws
from sar_tui.store.people_events import Details, new_event
from tests.store.by_hand import insert, sql, value
from tests.store.merge.sites import copy, holds, merge, site
from tests.store.persons import fill, holding, played

PAIRS = {"attempts": 1, "prompts_per_attempt": 4}


def whole(folder: Path) -> bool:
    with closing(connect(folder)) as database:
        return list(flaws(database)) == []


def codes(folder: Path) -> set[str]:
    return {code for (code,) in sql(folder, "SELECT DISTINCT participant FROM seats")}


@pytest.fixture
def bern(tmp_path: Path) -> Path:
    folder = site(tmp_path / "bern", "BERN")
    fill(folder)
    with closing(connect(folder)) as database:
        participants.add(database, "P08")
    played(folder, "pairs", "P07", "P08", word="CANARY", **PAIRS)
    return folder


@pytest.fixture
def zurich(tmp_path: Path, bern: Path) -> Path:
    folder = site(tmp_path / "zurich", "ZURICH")
    with closing(connect(folder)) as database:
        participants.add(database, "Z01")
    played(folder, "keyboard", "Z01", **PAIRS)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("what", ["erased", "de-identified"])
def test_it_is_so_whatever_the_order(what: str, bern: Path, zurich: Path, tmp_path: Path) -> None:
    before = copy(bern, tmp_path / "before")
    merge(zurich, before)
    between = copy(zurich, tmp_path / "between")
    if what == "erased":
        erase(bern, "P07", author="ana", reason="")
    else:
        de_identify(bern, "P07", author="ana", reason="")
    left = codes(bern)
    found = []
    for number, order in enumerate(permutations((before, bern, between))):
        folder = site(tmp_path / f"chur-{number}", "CHUR")
        merge(folder, *order)
        found.append(holds(folder))
        assert codes(folder) == {"Z01@ZURICH", *(f"{code}@BERN" for code in left)}
        assert whole(folder)
        assert b"CANARY" not in dump(folder)
    assert all(each == found[0] for each in found)
    merge(zurich, bern)
    assert merge(zurich, before).backup is None
    assert holds(zurich) == found[0]
    assert merge(bern, before, one_site=True).refused or what != "erased"
    merge(bern, zurich, between)
    assert holds(bern) == found[0]
    assert b"CANARY" not in dump(bern)
    again = merge(bern, before, one_site=True)
    assert again.backup is None
    if what == "erased":
        assert "P07@BERN was erased on" in again.refused[0].replace("P07 ", "P07@BERN ")


def dump(folder: Path) -> bytes:
    """Return all rows of a database, without those that are only free pages."""
    with closing(connect(folder)) as database:
        return "\n".join(database.iterdump()).encode()


def test_only_its_own_site_erases_a_person(bern: Path, zurich: Path) -> None:
    merge(zurich, bern)
    for code, own in (("P07", ""), ("P07@BERN", "")):
        given = {"id": f"x{len(code)}", "event": "erased", "participant": code, "site": own}
        insert(zurich, "people_events", at="2026-03-01", **given)
    with closing(connect(zurich)) as database:
        database.execute("UPDATE people_events SET site='BERN' WHERE id='x8'")
    merged = merge(bern, zurich)
    assert any("ZURICH says that P07@BERN was erased here" in each for each in merged.refused)
    assert "P07" in codes(bern)


def test_a_person_with_two_codes_does_not_come_back(bern: Path, zurich: Path) -> None:
    merge(bern, zurich, same=("P07=Z01@ZURICH",))
    assert codes(bern) == {"P07", "P08"}
    erase(bern, "P07", author="ana", reason="")
    assert value(bern, "SELECT count(*) FROM sessions") == 1
    merged = merge(bern, zurich)
    assert "P07 was erased on" in merged.refused[0]
    assert value(bern, "SELECT count(*) FROM sessions") == 1
    merge(zurich, bern)
    assert value(zurich, "SELECT count(*) FROM sessions WHERE site=''") == 1, "their own"


def test_a_site_completes_what_its_merge_began(bern: Path, zurich: Path) -> None:
    merge(zurich, bern)
    assert holding(zurich)
    erase(bern, "P07", author="ana", reason="")
    merged = merge(zurich, bern)
    assert merged.erased == ["P07@BERN"]
    assert holding(zurich), "the backup, and free pages"
    done = erase(zurich, "P07@BERN", author="ben", reason="")
    assert holding(zurich) == []
    assert done.rewritten == [merged.backup]
    assert whole(zurich)


def test_withdrawals_are_merged_and_the_last_one_counts(bern: Path, zurich: Path) -> None:
    given = {"author": "ana", "reason": ""}
    with closing(connect(bern)) as database:
        for what, data in (("withdrawn", "exclude"), ("resumed", ""), ("withdrawn", "exclude")):
            details = Details(data=data)  # type: ignore[arg-type]
            people_events.add(database, new_event(what, "P08", details=details, **given))  # type: ignore[arg-type]
    merge(zurich, bern)
    with closing(connect(zurich)) as database:
        assert list(people_events.excluded(database)) == ["P08@BERN"]
    with closing(connect(bern)) as database:
        people_events.add(database, new_event("resumed", "P08", **given))
    merge(zurich, bern)
    with closing(connect(zurich)) as database:
        assert people_events.excluded(database) == {}
    assert holds(zurich)["people_events"] == holds(bern)["people_events"]


def test_a_moved_session_is_moved_everywhere(bern: Path, zurich: Path, tmp_path: Path) -> None:
    before = copy(bern, tmp_path / "before")
    merge(zurich, before)
    (session,) = sql(
        bern, "SELECT session FROM seats JOIN sessions ON id=session WHERE mode='live' "
        "GROUP BY session HAVING count(*)=1",
    )[0]  # fmt: skip
    with closing(connect(bern)) as database:
        who = {"actor": "ana", "reason": "a typing error"}
        assert record_changes.move(database, bern, session, "A", "P08", **who) == "P07"
    records = "SELECT participant FROM records WHERE session=?"
    assert sql(bern, records, session) == [("P08",)]
    assert whole(bern)
    third = site(tmp_path / "chur", "CHUR")
    merge(third, bern, before)
    merge(zurich, bern)
    merge(zurich, before)
    merge(third, zurich)
    for folder in (zurich, third):
        assert merge(folder, None).conflicts == []
        assert sql(folder, records, session) == [("P08@BERN",)]
        assert value(folder, "SELECT participant FROM seats WHERE session=?", session) == "P08@BERN"
        assert whole(folder)
    assert holds(zurich) == holds(third)
    assert merge(bern, before, one_site=True).backup is None


@pytest.mark.parametrize("order", [*permutations(("before", "between", "bern"))], ids="-".join)
def test_a_session_of_two_who_were_erased_does_not_come_back(
    order: tuple[str, ...], bern: Path, tmp_path: Path
) -> None:
    found = {"before": copy(bern, tmp_path / "before"), "bern": bern}
    erase(bern, "P07", author="ana", reason="")
    found["between"] = copy(bern, tmp_path / "between")
    erase(bern, "P08", author="ana", reason="")
    assert codes(bern) == set()
    chur = site(tmp_path / "chur", "CHUR")
    merge(chur, *(found[name] for name in order))
    assert codes(chur) == set()
    assert holds(chur) == holds(bern)
    assert whole(chur)
    merge(bern, found["before"], one_site=True)
    assert codes(bern) == set()


@pytest.mark.parametrize("how", ["erased", "de-identified"])
def test_what_is_done_twice_is_done_once_to_each_session(
    how: str, bern: Path, zurich: Path, tmp_path: Path
) -> None:
    before = copy(bern, tmp_path / "before")
    new = de_identify(bern, "P07", author="ana", reason="why").event.participant
    between = copy(bern, tmp_path / "between")
    merge(zurich, between)
    if how == "erased":
        erase(bern, new, author="ana", reason="")
    else:
        de_identify(bern, new, author="ana", reason="")
    left, of_bern = holds(bern), {f"{code}@BERN" for code in codes(bern)}
    third = site(tmp_path / "chur", "CHUR")
    merge(third, between, bern)
    assert holds(third) == left
    merge(zurich, bern)
    assert codes(zurich) == {"Z01", *of_bern}
    assert merge(zurich, between).backup is None
    assert merge(bern, between, one_site=True).backup is None
    merge(bern, before, one_site=True)
    assert {f"{code}@BERN" for code in codes(bern)} == of_bern
    assert b"CANARY" not in dump(bern)
    assert how == "de-identified" or holds(bern) == left
    assert all(map(whole, (bern, zurich, third)))

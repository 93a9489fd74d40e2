"""A merge brings in all that another database has, once, whatever the order."""

import shutil
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.store import sessions
from sar_tui.store.database import FILE, connect
from sar_tui.store.merge.merge import Merged
from sar_tui.store.record_changes import BY_MISTAKE, change_status
from tests.store.by_hand import value
from tests.store.merge.sites import change, copy, go_on, holds, merge, play, save_programme, site


def kept_in(folder: Path, response: str) -> int:
    """Return the number of trials with a response."""
    return int(value(folder, "SELECT count(*) FROM trials WHERE response=?", response))


@pytest.fixture
def zurich(tmp_path: Path) -> Path:
    folder = site(tmp_path / "zurich", "ZURICH")
    play(folder, "a1")
    save_programme(folder, "P01", 1, '{"attempts":5}')
    return folder


@pytest.fixture
def bern(tmp_path: Path) -> Path:
    folder = site(tmp_path / "bern", "BERN")
    play(folder, "b1", began="2026-02-01T10:00:00+00:00")
    save_programme(folder, "P01", 1, '{"attempts":9}')
    return folder


def test_the_same_code_at_two_sites_is_two_people(zurich: Path, bern: Path) -> None:
    merged = merge(zurich, bern)
    assert (merged.site, merged.other, merged.added) == ("ZURICH", "BERN", ["b1"])
    found = holds(zurich)
    assert {row[2]: row[0] for row in found["seats"]} == {"P01@ZURICH": "a1", "P01@BERN": "b1"}
    assert found == holds(bern) | found
    assert merged.conflicts == []


def test_merging_again_changes_nothing(zurich: Path, bern: Path) -> None:
    assert merge(zurich, bern).backup
    before = holds(zurich)
    none = dict.fromkeys("same_people participants exports programmes records".split(), 0)
    assert merge(zurich, bern) == Merged(site="ZURICH", other="BERN", records=none)
    assert holds(zurich) == before
    merge(bern, zurich)
    assert holds(bern) == holds(zurich)


def test_a_session_discarded_there_counts_no_more_until_restored(zurich: Path, bern: Path) -> None:
    merge(zurich, bern)
    for status, here in (("discarded", "discarded"), ("restored", "interrupted")):
        with closing(connect(bern)) as database:
            who: Any = {"actor": "participant", "reason": BY_MISTAKE}
            assert change_status(database, bern, "b1", status, **who)  # type: ignore[arg-type]
        assert merge(zurich, bern).conflicts == []
        with closing(connect(zurich)) as database:
            # restored, its log knows no end
            assert sessions.stored_status(database, "b1") == here


def test_a_session_that_went_on_is_brought_up_to_date(
    zurich: Path, bern: Path, tmp_path: Path
) -> None:
    play(bern, "b2", status="interrupted")
    earlier = copy(bern, tmp_path / "earlier")
    merge(zurich, bern)
    go_on(bern, "b2")
    merged = merge(zurich, bern)
    assert (merged.added, merged.updated, merged.conflicts) == ([], ["b2"], [])
    assert holds(zurich) == holds(bern) | holds(zurich)
    assert merge(zurich, earlier).backup is None


def test_a_session_that_went_on_twice_is_kept_twice(
    zurich: Path, bern: Path, tmp_path: Path
) -> None:
    play(bern, "b2", status="interrupted")
    other = copy(bern, tmp_path / "other")
    go_on(bern, "b2", response="j")
    go_on(other, "b2", trials=2, response="k")
    third = copy(zurich, tmp_path / "third")
    assert len(merge(zurich, bern, other).conflicts) == 1
    assert [each.key for each in merge(third, other, bern, other).conflicts] == ["b2"]
    assert holds(third) == holds(zurich)
    assert kept_in(zurich, "k") == 2
    go_on(bern, "b2", trials=5, response="j")
    assert merge(zurich, bern).updated == ["b2"]
    merge(third, bern)
    assert holds(third) == holds(zurich)
    assert kept_in(zurich, "j") == 6
    assert len(merge(zurich, other, bern).conflicts) == 1


def test_both_versions_of_a_programme_are_kept(zurich: Path, bern: Path, tmp_path: Path) -> None:
    other = copy(bern, tmp_path / "other")
    save_programme(bern, "P01", 2, '{"attempts":1}')
    save_programme(other, "P01", 2, '{"attempts":2}')
    third = copy(zurich, tmp_path / "third")
    assert merge(zurich, bern, other).new_conflicts == 1
    merge(third, other, bern)
    assert [(each.kind, each.key) for each in merge(third, None).conflicts] == [
        ("programme", "P01@BERN keyboard 2")
    ]
    assert holds(third) == holds(zurich)
    merge(bern, other, one_site=True)
    merge(bern, zurich)
    assert holds(bern) == holds(zurich)


@pytest.mark.parametrize("first", [True, False])
def test_one_person_with_two_codes_is_one_person(zurich: Path, bern: Path, first: bool) -> None:
    play(bern, "b3", "P02")
    if first:
        merge(zurich, None, same=("P01@BERN=P01",))
        merge(zurich, bern)
    else:
        merge(zurich, bern)
        merge(zurich, None, same=("p01@bern = p01",))
    found = holds(zurich)
    # the first of a person's names
    assert {row[2] for row in found["seats"]} == {"P01@BERN", "P02@BERN"}
    play(bern, "b4")
    merge(zurich, bern)
    merge(bern, zurich, same=("P01=P01@ZURICH",) if first else ())
    if not first:
        merge(bern, zurich, same=("P01=P01@ZURICH",))
    assert holds(bern) == holds(zurich)
    assert {row[0] for row in holds(bern)["seats"] if row[2] == "P01@BERN"} == {"a1", "b1", "b4"}
    assert len(holds(bern)["programmes"]) == 2


def test_a_change_by_another_program_is_kept(zurich: Path, bern: Path, tmp_path: Path) -> None:
    other = copy(bern, tmp_path / "other")
    change(other, "UPDATE trials SET response='q' WHERE trial=1")
    third = copy(zurich, tmp_path / "third")
    merge(zurich, bern, other)
    merge(third, other, bern)
    assert [each.key for each in merge(zurich, None).conflicts] == ["b1"]
    assert holds(third) == holds(zurich)


@pytest.mark.parametrize("is_open", [True, False])
def test_the_newest_are_read_from_the_log(
    zurich: Path, bern: Path, tmp_path: Path, is_open: bool
) -> None:
    """A program that has the other database open, or was killed, leaves its newest rows in a log
    beside it.
    """

    def files() -> dict[str, bytes]:
        found = [path for path in other.iterdir() if path.is_file() and "shm" not in path.name]
        return {path.name: path.read_bytes() for path in found}

    with closing(connect(bern)) as holding:
        holding.execute("PRAGMA wal_autocheckpoint=0")
        play(bern, "b2")
        other = bern
        if not is_open:
            other = tmp_path / "stick"
            other.mkdir()
            for name in (FILE, f"{FILE}-wal"):
                shutil.copyfile(bern / name, other / name)
        before = files()
        assert merge(zurich, other).added == ["b1", "b2"]
        assert files() == before

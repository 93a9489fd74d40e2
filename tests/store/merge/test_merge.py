"""A merge brings in all that another database has, once, whatever the order."""

import os
import shutil
import sqlite3
import stat
import subprocess
import sys
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.store import sessions
from sar_tui.store.database import FILE, StoreConnection, StoreError, connect
from sar_tui.store.merge.merge import Merged
from sar_tui.store.record_changes import BY_MISTAKE, change_status
from tests.store.by_hand import sql, value
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


def test_the_same_code_at_two_sites_is_two_people_and_merging_again_changes_nothing(
    zurich: Path, bern: Path
) -> None:
    merged = merge(zurich, bern)
    assert (merged.site, merged.other, merged.added) == ("ZURICH", "BERN", ["b1"])
    assert merged.backup
    found = holds(zurich)
    assert {row[2]: row[0] for row in found["seats"]} == {"P01@ZURICH": "a1", "P01@BERN": "b1"}
    assert found == holds(bern) | found
    assert merged.conflicts == []
    tables = "same_people participants exports people_events studies programmes records"
    none = dict.fromkeys(tables.split(), 0)
    assert merge(zurich, bern) == Merged(site="ZURICH", other="BERN", records=none)
    assert holds(zurich) == found
    merge(bern, zurich)
    assert holds(bern) == found


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
    # the first of a person's names
    assert {row[2] for row in holds(zurich)["seats"]} == {"P01@BERN", "P02@BERN"}
    play(bern, "b4")
    merge(zurich, bern)
    if not first:
        merge(bern, zurich)
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


# --- undone


def stopped(*_: object) -> None:
    raise KeyboardInterrupt("stopped")


def full(folder: Path) -> StoreConnection:
    opened = connect(folder)
    sql(opened, f"PRAGMA max_page_count={value(opened, 'PRAGMA page_count')}")
    return opened


@pytest.mark.parametrize(
    ("place", "fails", "error", "says"),
    [
        ("put_in_order", stopped, KeyboardInterrupt, "stopped"),
        ("connect", full, StoreError, "The disk is full"),
        ("FOLDER", "sar-tui.db", StoreError, "cannot be written to"),
    ],
)
def test_a_merge_that_is_stopped_or_out_of_disk_leaves_the_database_as_it_was(
    zurich: Path,
    bern: Path,
    monkeypatch: pytest.MonkeyPatch,
    place: str,
    fails: object,
    error: type[BaseException],
    says: str,
) -> None:
    play(bern, "b2", trials=100)
    before = holds(zurich)
    with monkeypatch.context() as patch:
        patch.setattr(f"sar_tui.store.merge.merge.{place}", fails)
        with pytest.raises(error, match=says):
            merge(zurich, bern)
    assert holds(zurich) == before
    assert not list(zurich.glob(".merge-*"))
    merged = merge(zurich, bern)
    assert merged.added == ["b1", "b2"]
    assert merged.backup
    with closing(sqlite3.connect(merged.backup)) as backup:
        assert sql(backup, "SELECT id FROM sessions") == [("a1",)], "what there was before"


_KILLED = """
import os, signal, sys
from pathlib import Path
from sar_tui.store.merge import merge

merge.put_in_order = lambda *_: os.kill(os.getpid(), signal.SIGKILL)
merge.merge(Path(sys.argv[1]), Path(sys.argv[2]), start=lambda step: lambda done, total: None)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_the_next_merge_removes_what_a_killed_one_left(zurich: Path, bern: Path) -> None:
    before = holds(zurich)
    command = [sys.executable, "-c", _KILLED, zurich, bern]
    assert subprocess.run(command, check=False, capture_output=True).returncode == -9
    (left,) = zurich.glob(".merge-*")
    assert stat.S_IMODE(left.stat().st_mode) == 0o700
    assert stat.S_IMODE((left / FILE).stat().st_mode) == 0o600
    assert holds(zurich) == before
    assert merge(zurich, bern).added == ["b1"]
    assert not list(zurich.glob(".merge-*"))


@pytest.mark.parametrize("which", ["zurich", "bern"])
def test_invented_people_of_a_demonstration_are_not_merged(
    zurich: Path, bern: Path, which: str
) -> None:
    change({"zurich": zurich, "bern": bern}[which], "UPDATE sessions SET mode='demonstration'")
    before = holds(zurich)
    with pytest.raises(StoreError, match="invented"):
        merge(zurich, bern)
    assert holds(zurich) == before

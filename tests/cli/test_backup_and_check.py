"""``sar-tui backup`` and ``sar-tui check``."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.store.database import FILE
from tests.program import Call
from tests.runs.test_resume import interrupted


@pytest.mark.usefixtures("simulated")
def test_whole_data_is_told_with_its_numbers(call: Call, tmp_path: Path) -> None:
    called = call("check")
    assert called.code == 0
    assert called.out == f"All data in {tmp_path / 'data'} is whole (4 attempts, 80 trials).\n"
    assert call("check --json").json["flaws"] == []


def test_flaws_are_named_with_their_session(call: Call, simulated: str, tmp_path: Path) -> None:
    with closing(sqlite3.connect(tmp_path / "data" / FILE, isolation_level=None)) as database:
        database.execute("DELETE FROM trials WHERE attempt=2 AND trial=3")
    called = call("check")
    missing = "Of 20 trials of attempt 2, 1 are missing."
    altered = "Rows of trials are not as its log has them: 1 missing."
    assert (called.code, called.out) == (1, f"✗ {simulated}: {missing}\n✗ {simulated}: {altered}\n")
    assert call("check --json").json["flaws"] == [
        {"kind": "gap", "where": simulated, "what": missing},
        {"kind": "rows", "where": simulated, "what": altered},
    ]
    called = call("backup --verify")
    assert called.code == 1
    assert f"✗ {simulated}: Of 20 trials" in called.out


@pytest.mark.usefixtures("simulated")
def test_a_backup_says_where_it_is_and_can_be_verified(call: Call, tmp_path: Path) -> None:
    called = call("backup --to", tmp_path / "mine.db", "--verify")
    assert called.code == 0
    assert called.out.splitlines() == [
        f"1 session in {tmp_path / 'mine.db'}",
        "It was restored into an empty folder: it opens there, and all of it is whole.",
    ]
    again = call("backup --to", tmp_path / "mine.db")
    assert (again.code, again.err) == (
        2,
        f"{tmp_path / 'mine.db'} exists, and a backup replaces nothing. Name another file.\n",
    )
    made = call("backup --json --verify").json
    assert Path(made["file"]).parent == tmp_path / "data" / "backups"
    assert (made["sessions"], made["verified"]) == (1, True)


def test_without_data_there_is_nothing_to_back_up(call: Call) -> None:
    called = call("backup")
    assert called.code == 2
    assert called.err.startswith("There is no data in ")


def test_an_interrupted_session_is_told_and_is_no_flaw(call: Call, tmp_path: Path) -> None:
    session = interrupted(tmp_path / "data")
    called = call("check")
    assert called.code == 0
    assert f"{session}: This session was interrupted" in called.out
    assert call("check --json").json["interrupted"] == [session]


def test_damaged_characters_do_not_stop_the_check(
    call: Call, simulated: str, tmp_path: Path
) -> None:
    with closing(sqlite3.connect(tmp_path / "data" / FILE, isolation_level=None)) as database:
        database.execute("UPDATE trials SET stimulus=CAST(x'ff' AS TEXT) WHERE trial=1")
    called = call("check")
    assert (called.code, called.err) == (1, "")
    assert (
        f"{simulated}: 4 of the rows of trials have characters that cannot be read." in called.out
    )


def test_a_repair_says_what_it_moved_where(call: Call, simulated: str, tmp_path: Path) -> None:
    with closing(sqlite3.connect(tmp_path / "data" / FILE, isolation_level=None)) as database:
        database.execute("UPDATE sessions SET machine='{'")
    called = call("check --repair --json")
    assert called.code == 0
    done = called.json["repair"]
    assert {
        "table": "sessions",
        "rows": 1,
        "reason": "a text sessions.machine that cannot be read",
    } in done["moved"]
    assert Path(done["aside"]).parent == tmp_path / "data"
    assert Path(done["backup"]).parent == tmp_path / "data" / "backups"
    assert called.json["flaws"] == []


@pytest.mark.usefixtures("simulated")
def test_a_repair_of_whole_data_says_that_nothing_was_changed(call: Call) -> None:
    called = call("check --repair")
    assert called.code == 0
    assert called.out.startswith(
        "There is nothing to move aside, and nothing was changed.\nAll data in "
    )


def test_a_folder_without_data_is_not_called_whole(call: Call, tmp_path: Path) -> None:
    assert call("check --data", tmp_path / "typo") == (
        2,
        "",
        f"There is no data in {tmp_path / 'typo'} yet.\n",
    )
    assert not (tmp_path / "typo").exists()

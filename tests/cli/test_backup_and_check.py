"""``sar-tui backup`` and ``sar-tui check``."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.store.database import FILE
from tests.program import Call
from tests.runs.test_resume import interrupted


def alter(data: Path, statement: str) -> None:
    with closing(sqlite3.connect(data / FILE, isolation_level=None)) as database:
        database.execute(statement)


@pytest.mark.usefixtures("simulated")
def test_whole_data_is_told_with_its_numbers(call: Call, data: Path) -> None:
    whole = f"All data in {data} is whole (4 attempts, 80 trials).\n"
    call("check").shows(whole)
    assert call("check --json").json["flaws"] == []
    call("check --repair").shows("There is nothing to move aside, and nothing was changed.", whole)


def test_flaws_are_named_with_their_session_and_a_repair_says_what_it_moved_where(
    call: Call, simulated: str, data: Path
) -> None:
    alter(data, "DELETE FROM trials WHERE attempt=2 AND trial=3")
    missing = "Of 20 trials of attempt 2, 1 are missing."
    altered = "Rows of trials are not as its log has them: 1 missing."
    call("check").shows(f"✗ {simulated}: {missing}\n✗ {simulated}: {altered}\n", code=1)
    assert call("check --json").json["flaws"] == [
        {"kind": "gap", "where": simulated, "what": missing},
        {"kind": "rows", "where": simulated, "what": altered},
    ]
    call("backup --verify").shows(f"✗ {simulated}: Of 20 trials", code=1)
    alter(data, "UPDATE trials SET stimulus=CAST(x'ff' AS TEXT) WHERE trial=1")
    said = f"{simulated}: 4 of the rows of trials have characters that cannot be read."
    call("check").shows(said, code=1)
    alter(data, "UPDATE sessions SET machine='{'")
    called = call("check --repair --json")
    assert (called.code, called.json["flaws"]) == (0, [])
    done = called.json["repair"]
    reason = "a text sessions.machine that cannot be read"
    assert {"table": "sessions", "rows": 1, "reason": reason} in done["moved"]
    assert Path(done["aside"]).parent == data
    assert Path(done["backup"]).parent == data / "backups"
    session = interrupted(data)
    call("check").shows(f"{session}: This session was interrupted")
    assert call("check --json").json["interrupted"] == [session]


@pytest.mark.usefixtures("simulated")
def test_a_backup_says_where_it_is_and_can_be_verified(
    call: Call, data: Path, tmp_path: Path
) -> None:
    file = tmp_path / "mine.db"
    call("backup --verify --to", file).shows(f"1 session in {file}\n", "all of it is whole.")
    call("backup --to", file).refused(f"{file} exists, and a backup replaces nothing.")
    made = call("backup --json --verify").json
    assert Path(made["file"]).parent == data / "backups"
    assert (made["sessions"], made["verified"]) == (1, True)


def test_a_folder_without_data_is_not_called_whole(call: Call, tmp_path: Path) -> None:
    said = f"There is no data in {tmp_path / 'typo'} yet."
    call("check --data", tmp_path / "typo").refused(said)
    assert not (tmp_path / "typo").exists()
    call("backup").refused("There is no data in ")

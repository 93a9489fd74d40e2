"""A backup is whole or absent, replaces nothing, and opens as data."""

import os
import signal
import sqlite3
import stat
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import participants
from sar_tui.store.backup import back_up, rehearse
from sar_tui.store.database import FILE, StoreError, connect
from sar_tui.store.integrity import counts
from sar_tui.store.locks import hold


@pytest.fixture
def database(data: Path, catalogue: Catalogue) -> Iterator[sqlite3.Connection]:
    """The open database, with a session."""
    settings = {"attempts": 2, "prompts_per_attempt": 3}
    simulate(
        make_plan(catalogue, "keyboard", ["P01"], settings, mode="simulated"),
        PEOPLE["poor"],
        data,
        catalogue,
    )
    with closing(connect(data)) as opened:
        yield opened


def test_a_backup_holds_all_rows_and_only_its_owner_can_read_it(
    database: sqlite3.Connection, data: Path, tmp_path: Path
) -> None:
    made = back_up(data, tmp_path / "safe")
    assert made.path.parent == tmp_path / "safe"
    assert list(made.path.parent.iterdir()) == [made.path]
    with closing(sqlite3.connect(made.path)) as copy:
        assert counts(copy) == counts(database)
    assert (made.sessions, made.bytes) == (1, made.path.stat().st_size)
    if sys.platform != "win32":
        assert stat.S_IMODE(made.path.stat().st_mode) == 0o600


def test_a_backup_is_made_while_something_is_written(
    database: sqlite3.Connection, data: Path
) -> None:
    participants.add(database, "P07")  # in the write-ahead log only
    database.execute("BEGIN IMMEDIATE")
    database.execute("INSERT INTO participants (code, created_at) VALUES ('P08', '')")
    made = back_up(data)
    database.execute("ROLLBACK")
    with closing(sqlite3.connect(made.path)) as copy:
        assert copy.execute("SELECT code FROM participants").fetchall() == [("P07",)]
    assert rehearse(made.path) == []


def test_a_rehearsal_finds_damage(database: sqlite3.Connection, data: Path) -> None:
    made = back_up(data)
    with closing(sqlite3.connect(made.path, isolation_level=None)) as copy:
        copy.execute("DELETE FROM messages WHERE seq=3")
    before = made.path.read_bytes()
    assert {flaw.kind for flaw in rehearse(made.path)} == {"gap", "log"}
    assert made.path.read_bytes() == before


def test_a_backup_replaces_nothing(
    database: sqlite3.Connection, data: Path, tmp_path: Path
) -> None:
    there = tmp_path / "mine.db"
    there.write_text("mine")
    with pytest.raises(StoreError, match="replaces nothing"):
        back_up(data, there)
    assert there.read_text() == "mine"


def test_without_data_there_is_no_backup(data: Path) -> None:
    with pytest.raises(StoreError, match="There is no data"):
        back_up(data)
    assert not data.exists()


def test_a_copy_that_lacks_rows_is_not_kept(
    database: sqlite3.Connection, data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    true = counts(database)
    seen = iter([{**true, "trials": true["trials"] + 1}, true])
    monkeypatch.setattr("sar_tui.store.backup.counts", lambda _: next(seen))
    with pytest.raises(StoreError, match="lacks rows of trials"):
        back_up(data, tmp_path / "safe")
    assert os.listdir(tmp_path / "safe") == []


@pytest.mark.skipif(sys.platform == "win32", reason="ends a program with a signal")
def test_what_a_killed_backup_left_is_removed_by_the_next(
    database: sqlite3.Connection, data: Path, tmp_path: Path
) -> None:
    safe = tmp_path / "safe"
    killed = (
        "import os, signal, sys; from pathlib import Path; from sar_tui.store import backup;"
        "backup._sync = lambda copy: os.kill(os.getpid(), signal.SIGKILL);"
        "backup.back_up(Path(sys.argv[1]), Path(sys.argv[2]))"
    )
    run = subprocess.run(
        [sys.executable, "-c", killed, str(data), str(safe)], timeout=60, check=False
    )
    assert run.returncode == -signal.SIGKILL
    (left,) = safe.iterdir()
    assert left.suffix == ".part"
    made = back_up(data, safe)
    assert list(safe.iterdir()) == [made.path]
    assert rehearse(made.path) == []


def test_two_backups_of_a_folder_are_not_made_at_once(
    database: sqlite3.Connection, data: Path, tmp_path: Path
) -> None:
    with hold(data, "backup", "all"), pytest.raises(StoreError, match="Another backup"):
        back_up(data, tmp_path / "safe")


@pytest.mark.skipif(sys.platform == "win32", reason="limits the size of files")
def test_a_full_disk_leaves_no_backup_and_the_database_as_it_was(
    database: sqlite3.Connection, data: Path, tmp_path: Path
) -> None:
    limited = (
        "import resource, signal, sys; from pathlib import Path; from sar_tui.store.backup import "
        "back_up;"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (65536, 65536));"
        "back_up(Path(sys.argv[1]), Path(sys.argv[2]))"
    )
    before = counts(database)
    run = subprocess.run(
        [sys.executable, "-c", limited, str(data), str(tmp_path / "safe")],
        timeout=60, check=False, capture_output=True, text=True,
    )  # fmt: skip
    assert "StoreError" in run.stderr, run.stderr
    assert list((tmp_path / "safe").iterdir()) == []
    assert counts(database) == before


def test_a_damaged_database_is_not_backed_up(
    database: sqlite3.Connection, data: Path, tmp_path: Path
) -> None:
    database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    (root,) = database.execute("SELECT rootpage FROM sqlite_master WHERE name='trials'").fetchone()
    (size,) = database.execute("PRAGMA page_size").fetchone()
    database.close()
    with (data / FILE).open("rb+") as file:
        file.seek((root - 1) * size)
        file.write(b"\xff" * 100)
    with pytest.raises(StoreError, match="damaged"):
        back_up(data, tmp_path / "safe")
    assert os.listdir(tmp_path / "safe") == []

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
from sqlite3 import Connection

import pytest

from sar_tui.store import participants
from sar_tui.store.backup import back_up, rehearse
from sar_tui.store.database import StoreError, connect
from sar_tui.store.integrity import counts
from sar_tui.store.locks import hold
from tests.played import simulated
from tests.store.by_hand import sql


@pytest.fixture
def database(data: Path) -> Iterator[Connection]:
    """The open database, with a session."""
    simulated(data, user="poor", attempts=2, prompts_per_attempt=3)
    with closing(connect(data)) as opened:
        yield opened


def test_a_backup_holds_all_rows_and_only_its_owner_can_read_it(
    database: Connection, data: Path, tmp_path: Path
) -> None:
    made = back_up(data, tmp_path / "safe")
    assert made.path.parent == tmp_path / "safe"
    assert list(made.path.parent.iterdir()) == [made.path]
    with closing(sqlite3.connect(made.path)) as copy:
        assert counts(copy) == counts(database)
    assert (made.sessions, made.bytes) == (1, made.path.stat().st_size)
    if sys.platform != "win32":
        assert stat.S_IMODE(made.path.stat().st_mode) == 0o600


def test_a_backup_is_made_while_something_is_written(database: Connection, data: Path) -> None:
    participants.add(database, "P07")  # in the write-ahead log only
    database.execute("BEGIN IMMEDIATE")
    database.execute("INSERT INTO participants (code, created_at) VALUES ('P08', '')")
    made = back_up(data)
    database.execute("ROLLBACK")
    with closing(sqlite3.connect(made.path)) as copy:
        assert copy.execute("SELECT code FROM participants").fetchall() == [("P07",)]
    assert rehearse(made.path) == []


def test_a_rehearsal_finds_damage(database: Connection, data: Path) -> None:
    made = back_up(data)
    with closing(sqlite3.connect(made.path, isolation_level=None)) as copy:
        sql(copy, "DELETE FROM messages WHERE seq=3")
    before = made.path.read_bytes()
    assert {flaw.kind for flaw in rehearse(made.path)} == {"gap", "log"}
    assert made.path.read_bytes() == before


def run(code: str, *arguments: Path) -> subprocess.CompletedProcess[str]:
    code = f"import os, resource, signal, sys; from pathlib import Path; from sar_tui.store import backup;{code}"
    code += "backup.back_up(Path(sys.argv[1]), Path(sys.argv[2]))"
    command = [sys.executable, "-c", code, *map(str, arguments)]
    return subprocess.run(command, timeout=60, check=False, capture_output=True, text=True)


def test_a_backup_replaces_nothing(database: Connection, data: Path, tmp_path: Path) -> None:
    there = tmp_path / "mine.db"
    there.write_text("mine")
    with pytest.raises(StoreError, match="replaces nothing"):
        back_up(data, there)
    assert there.read_text() == "mine"
    with pytest.raises(StoreError, match="There is no data"):
        back_up(tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_a_copy_that_lacks_rows_is_not_kept(
    database: Connection, data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    true = counts(database)
    seen = iter([{**true, "trials": true["trials"] + 1}, true])
    monkeypatch.setattr("sar_tui.store.backup.counts", lambda _: next(seen))
    with pytest.raises(StoreError, match="lacks rows of trials"):
        back_up(data, tmp_path / "safe")
    assert os.listdir(tmp_path / "safe") == []


@pytest.mark.skipif(sys.platform == "win32", reason="ends a program with a signal")
def test_the_next_removes_a_killed_backup(database: Connection, data: Path, tmp_path: Path) -> None:
    safe = tmp_path / "safe"
    killed = run(
        "backup.sync_file = lambda copy: os.kill(os.getpid(), signal.SIGKILL);", data, safe
    )
    assert killed.returncode == -signal.SIGKILL
    (left,) = safe.iterdir()
    assert left.suffix == ".part"
    made = back_up(data, safe)
    assert list(safe.iterdir()) == [made.path]
    assert rehearse(made.path) == []


@pytest.mark.skipif(sys.platform == "win32", reason="limits the size of files")
def test_a_full_disk_leaves_no_backup(database: Connection, data: Path, tmp_path: Path) -> None:
    limit = "resource.setrlimit(resource.RLIMIT_FSIZE, (65536, 65536));"
    before = counts(database)
    done = run(f"signal.signal(signal.SIGXFSZ, signal.SIG_IGN);{limit}", data, tmp_path / "safe")
    assert "StoreError" in done.stderr, done.stderr
    assert list((tmp_path / "safe").iterdir()) == []
    assert counts(database) == before


def test_two_backups_are_not_made_at_once(database: Connection, data: Path, tmp_path: Path) -> None:
    with hold(data, "backup", "all"), pytest.raises(StoreError, match="Another backup"):
        back_up(data, tmp_path / "safe")

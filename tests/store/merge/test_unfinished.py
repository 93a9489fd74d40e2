"""A merge that is stopped, killed or out of disk leaves the database as it was."""

import os
import sqlite3
import stat
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.store.database import FILE, StoreConnection, StoreError, connect
from tests.store.by_hand import sql, value
from tests.store.merge.sites import holds, merge, play, site


@pytest.fixture
def zurich(tmp_path: Path) -> Path:
    folder = site(tmp_path / "zurich", "ZURICH")
    play(folder, "a1")
    return folder


@pytest.fixture
def bern(tmp_path: Path) -> Path:
    folder = site(tmp_path / "bern", "BERN")
    for number in range(5):
        play(folder, f"b{number}", trials=20)
    return folder


def test_ctrl_c_undoes_it(zurich: Path, bern: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(db: sqlite3.Connection) -> None:
        raise KeyboardInterrupt

    before = holds(zurich)
    monkeypatch.setattr("sar_tui.store.merge.merge.put_in_order", stop)
    with pytest.raises(KeyboardInterrupt):
        merge(zurich, bern)
    assert holds(zurich) == before
    assert not list(zurich.glob(".merge-*"))


def test_a_full_disk_undoes_it(zurich: Path, bern: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(folder: Path) -> StoreConnection:
        opened = connect(folder)
        sql(opened, f"PRAGMA max_page_count={value(opened, 'PRAGMA page_count')}")
        return opened

    before = holds(zurich)
    with monkeypatch.context() as patch:
        patch.setattr("sar_tui.store.merge.merge.connect", full)
        with pytest.raises(StoreError, match="The disk is full"):
            merge(zurich, bern)
    assert holds(zurich) == before
    merged = merge(zurich, bern)
    assert merged.added == [f"b{number}" for number in range(5)]
    assert merged.backup
    with closing(sqlite3.connect(merged.backup)) as backup:
        assert sql(backup, "SELECT id FROM sessions") == [("a1",)], "what there was before"


def test_a_backup_that_cannot_be_made_undoes_it(zurich: Path, bern: Path) -> None:
    before = holds(zurich)
    (zurich / "backups").write_text("a file")
    with pytest.raises(StoreError, match="cannot be written to"):
        merge(zurich, bern)
    assert holds(zurich) == before


_KILLED = """
import os, signal, sys
from pathlib import Path
from sar_tui.store.merge import merge

merge.put_in_order = lambda db: os.kill(os.getpid(), signal.SIGKILL)
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
    assert len(merge(zurich, bern).added) == 5
    assert not list(zurich.glob(".merge-*"))

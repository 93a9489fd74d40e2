"""A repair moves what is damaged aside: each row stays in at least one file, and what is left is
whole.
"""

import signal
import sqlite3
import stat
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.store.database import FILE, StoreError, connect
from sar_tui.store.integrity import counts, flaws
from sar_tui.store.repair import Moved, repair
from tests.examples import first
from tests.played import simulated
from tests.store.by_hand import sql, value


@pytest.fixture
def recorded(data: Path) -> Path:
    """The data folder, with two sessions."""
    simulated(data, attempts=2, prompts_per_attempt=60)
    simulated(data, "reaching", attempts=2)
    return data


def change(folder: Path, *statements: str) -> dict[str, int]:
    """Change the database, and return the number of rows of each table."""
    with closing(connect(folder)) as database:
        for statement in statements:
            sql(database, statement)
        return counts(database)


def rows(path: Path, table: str, columns: str = "*") -> list[tuple[object, ...]]:
    with closing(sqlite3.connect(path)) as database:
        return sql(database, f"SELECT {columns} FROM {table}")


def damage_page(folder: Path, table: str, leaf: bool) -> None:
    """Overwrite the root page of a table, or the page of its first rows."""
    sql(folder, "PRAGMA wal_checkpoint(TRUNCATE)")
    size = value(folder, "PRAGMA page_size")
    page = value(folder, "SELECT rootpage FROM sqlite_master WHERE name=?", table)
    with (folder / FILE).open("rb+") as file:
        if leaf:  # the first cell of an interior page begins with the number of its child
            file.seek((page - 1) * size)
            content = file.read(size)
            assert content[0] in (2, 5), "the table has one page only"
            cell = int.from_bytes(content[12:14], "big")
            page = int.from_bytes(content[cell : cell + 4], "big")
        file.seek((page - 1) * size)
        file.write(b"\xff" * size)


def test_whole_data_is_not_changed(recorded: Path) -> None:
    before = (recorded / FILE).read_bytes()
    names = {path.name for path in recorded.iterdir()}
    done = repair(recorded)
    assert (done.backup, done.kept, done.aside) == (None, None, None)
    assert (done.moved, done.flaws) == ([], [])
    assert (recorded / FILE).read_bytes() == before
    assert {path.name for path in recorded.iterdir()} - {"locks"} == names - {"locks"}


def test_a_damaged_block_of_samples_moves_aside_as_it_is(recorded: Path) -> None:
    before = change(recorded, "UPDATE imu_chunks SET data=x'00' WHERE seq=2")["imu_chunks"]
    done, why = repair(recorded), "a damaged block of samples"
    assert done.moved == [Moved("imu_chunks", 1, why)]
    assert done.aside
    assert done.backup
    assert rows(done.aside, "imu_chunks", "seq, data, why") == [(2, b"\0", why)]
    assert len(rows(recorded / FILE, "imu_chunks")) == before - 1
    assert len(rows(done.backup, "imu_chunks")) == before
    assert {flaw.kind for flaw in done.flaws} == {"gap", "log"}, "that it is missing is said"
    assert sys.platform == "win32" or stat.S_IMODE(done.aside.stat().st_mode) == 0o600


def test_a_session_with_unreadable_settings_moves_aside_with_all_its_rows(recorded: Path) -> None:
    before = change(recorded, "UPDATE sessions SET parameters='{' WHERE task='keyboard'")
    done = repair(recorded)
    assert done.flaws == []
    assert done.aside
    after = change(recorded)
    for table in "sessions seats runs attempts trials messages session_numbers".split():
        assert before[table] - after[table] == len(rows(done.aside, table)) > 0


def test_damaged_characters_move_aside(recorded: Path) -> None:
    change(
        recorded,
        "UPDATE notes SET text=''",
        "UPDATE trials SET stimulus=CAST(x'61ff' AS TEXT) WHERE trial=60",
    )
    done = repair(recorded)
    assert done.aside
    assert rows(done.aside, "trials", "CAST(stimulus AS BLOB)")[0] == (b"a\xff",)
    assert repair(recorded).moved == []


def test_rows_without_their_session_move_aside_and_the_rest_is_whole(recorded: Path) -> None:
    change(recorded, "DELETE FROM sessions WHERE task='reaching'")
    done = repair(recorded)
    assert done.flaws == []
    tables = "seats runs attempts trials messages imu_chunks".split()
    assert {each.table for each in done.moved} >= set(tables)


def python(code: str, *arguments: object) -> subprocess.CompletedProcess[str]:
    code = f"import os, signal, sys; from pathlib import Path; from sar_tui.store import repair as r; {code}"
    command = [sys.executable, "-c", code, *map(str, arguments)]
    return subprocess.run(command, timeout=60, check=False, capture_output=True, text=True)


def test_an_open_database_is_not_repaired(recorded: Path) -> None:
    change(recorded, "DELETE FROM seats")
    with closing(connect(recorded)):
        done = python("r.repair(Path(sys.argv[1]))", recorded)
    assert done.returncode == 1
    assert "Another program has" in done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="ends a program with a signal")
@pytest.mark.parametrize("step", first(1, range(3)))
def test_a_killed_repair_loses_no_row_and_can_be_run_again(recorded: Path, step: int) -> None:
    damage = ("UPDATE trials SET timing='{' WHERE trial<3", "UPDATE attempts SET qualities='['")
    before = change(recorded, *damage)
    code = (
        "real = r._transaction; steps = iter(range(99));"
        "kill = lambda: os.kill(os.getpid(), signal.SIGKILL);"
        "r._transaction = lambda d: kill() if next(steps) == int(sys.argv[2]) else real(d);"
        "r.repair(Path(sys.argv[1]))"
    )
    assert python(code, recorded, step).returncode == -signal.SIGKILL
    repair(recorded)
    for table, count in before.items():
        kept = set(rows(recorded / FILE, table))
        for aside in recorded.glob("sar-tui-aside-*.db"):
            if rows(aside, f"sqlite_master WHERE name='{table}'"):
                kept |= {row[:-1] for row in rows(aside, table)}
        assert len(kept) >= count, table  # some were damaged, and made again from the log


@pytest.mark.parametrize(
    ("table", "leaf"), [("trials", True), ("trials", False), ("messages", True), ("notes", False)]
)
def test_what_can_be_read_of_damaged_pages_is_saved(recorded: Path, table: str, leaf: bool) -> None:
    before = change(recorded)
    damage_page(recorded, table, leaf)
    damaged = (recorded / FILE).read_bytes()
    done = repair(recorded)
    assert done.kept
    assert done.kept.read_bytes() == damaged
    after = change(recorded)
    assert {name for name in before if after[name] < before[name]} <= {table}
    if table == "messages":
        assert 0.3 * before[table] < after[table] < before[table]
    elif leaf:
        assert after[table] == before[table], "rows were made again from the log"
        assert done.rebuilt
    assert not [flaw for flaw in done.flaws if flaw.kind == "file"]
    assert done.unread or not before[table]
    assert all(bool(each.session) == (table == "messages") for each in done.unread)
    with closing(connect(recorded)) as database:
        assert not [flaw for flaw in flaws(database) if flaw.kind in ("file", "orphan")]


@pytest.mark.parametrize("damage", ["no header", "no schema", "a page is left"])
def test_a_file_of_which_nothing_can_be_read_is_left_as_it_is(recorded: Path, damage: str) -> None:
    sql(recorded, "PRAGMA wal_checkpoint(TRUNCATE)")
    with (recorded / FILE).open("rb+") as file:
        file.seek(100 if damage == "no schema" else 0)
        file.write({"no header": bytes(100), "no schema": b"\xff" * 3000}.get(damage, b""))
        if damage == "a page is left":
            file.truncate(3000)
    damaged = (recorded / FILE).read_bytes()
    with pytest.raises(StoreError, match=r"damaged|is not a SQLite database"):
        repair(recorded)
    assert (recorded / FILE).read_bytes() == damaged
    assert not list(recorded.glob("*.part"))

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

from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store.database import FILE, StoreError, connect
from sar_tui.store.integrity import counts, flaws
from sar_tui.store.repair import Moved, repair


@pytest.fixture
def recorded(data: Path, catalogue: Catalogue) -> Path:
    """The data folder, with two sessions."""
    for task, settings in {"keyboard": {"prompts_per_attempt": 60}, "reaching": {}}.items():
        plan = make_plan(
            catalogue, task, ["P01"], {"attempts": 2, **settings}, seed=3, mode="simulated"
        )
        simulate(plan, PEOPLE["average"], data, catalogue)
    return data


def change(folder: Path, *statements: str) -> dict[str, int]:
    """Change the database, and return the number of rows of each table."""
    with closing(connect(folder)) as database:
        for statement in statements:
            database.execute(statement)
        return counts(database)


def rows(path: Path, table: str, columns: str = "*") -> list[tuple[object, ...]]:
    with closing(sqlite3.connect(path)) as database:
        return database.execute(f"SELECT {columns} FROM {table} ORDER BY rowid").fetchall()


def damage_page(folder: Path, table: str, leaf: bool) -> None:
    """Overwrite the root page of a table, or the page of its first rows."""
    with closing(connect(folder)) as database:
        database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        (size,) = database.execute("PRAGMA page_size").fetchone()
        (root,) = database.execute(
            "SELECT rootpage FROM sqlite_master WHERE name=?", (table,)
        ).fetchone()
    with (folder / FILE).open("rb+") as file:
        page = root
        if leaf:  # the first cell of an interior page begins with the number of its child
            file.seek((root - 1) * size)
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
    assert (done.backup, done.kept, done.aside, done.moved, done.flaws) == (
        None,
        None,
        None,
        [],
        [],
    )
    assert (recorded / FILE).read_bytes() == before
    assert {path.name for path in recorded.iterdir()} - {"locks"} == names - {"locks"}


def test_a_damaged_block_of_samples_moves_aside_as_it_is(recorded: Path) -> None:
    before = change(recorded, "UPDATE imu_chunks SET data=x'00' WHERE seq=2")
    done = repair(recorded)
    assert done.moved == [Moved("imu_chunks", 1, "a damaged block of samples")]
    assert done.aside
    assert done.backup
    assert rows(done.aside, "imu_chunks", "seq, data, why") == [
        (2, b"\0", "a damaged block of samples")
    ]
    assert len(rows(recorded / FILE, "imu_chunks")) == before["imu_chunks"] - 1
    assert len(rows(done.backup, "imu_chunks")) == before["imu_chunks"]
    assert {flaw.kind for flaw in done.flaws} == {"gap", "log"}, (
        "it is missing now, and that is said"
    )
    if sys.platform != "win32":
        assert stat.S_IMODE(done.aside.stat().st_mode) == 0o600


def test_a_session_whose_settings_cannot_be_read_moves_aside_with_all_its_rows(
    recorded: Path,
) -> None:
    before = change(recorded, "UPDATE sessions SET parameters='{' WHERE task='keyboard'")
    done = repair(recorded)
    assert done.flaws == []
    assert done.aside
    after = change(recorded)
    for table in ("sessions", "seats", "runs", "attempts", "trials", "messages", "session_numbers"):
        with closing(sqlite3.connect(done.aside)) as aside:
            (moved,) = aside.execute(f"SELECT count(*) FROM {table}").fetchone()
        assert moved > 0
        assert moved + after[table] == before[table]


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
    assert {each.table for each in done.moved} >= {
        "seats",
        "runs",
        "attempts",
        "trials",
        "messages",
        "imu_chunks",
    }


def test_an_open_database_is_not_repaired(recorded: Path) -> None:
    change(recorded, "DELETE FROM seats")
    with closing(connect(recorded)), pytest.raises(StoreError, match="Another program has"):
        _in_another_process(recorded)


def _in_another_process(folder: Path) -> None:
    code = (
        "import sys; from pathlib import Path; from sar_tui.store.repair import repair; "
        "repair(Path(sys.argv[1]))"
    )
    run = subprocess.run(
        [sys.executable, "-c", code, str(folder)],
        timeout=60,
        check=False,
        capture_output=True,
        text=True,
    )
    assert run.returncode == 1
    raise StoreError(run.stderr)


@pytest.mark.skipif(sys.platform == "win32", reason="ends a program with a signal")
@pytest.mark.parametrize("step", range(3))
def test_a_killed_repair_loses_no_row_and_can_be_run_again(recorded: Path, step: int) -> None:
    before = change(
        recorded, "UPDATE trials SET timing='{' WHERE trial<3", "UPDATE attempts SET qualities='['"
    )
    code = (
        "import os, signal, sys; from pathlib import Path; from sar_tui.store import repair as r;"
        "real = r._transaction; steps = iter(range(99)); kill = lambda: os.kill(os.getpid(), "
        "signal.SIGKILL);"
        "r._transaction = lambda d: kill() if next(steps) == int(sys.argv[2]) else real(d);"
        "r.repair(Path(sys.argv[1]))"
    )
    run = subprocess.run(
        [sys.executable, "-c", code, str(recorded), str(step)], timeout=60, check=False
    )
    assert run.returncode == -signal.SIGKILL
    repair(recorded)
    for table, count in before.items():
        with closing(sqlite3.connect(recorded / FILE)) as opened:
            kept = set(opened.execute(f"SELECT * FROM {table}"))
        for aside in recorded.glob("sar-tui-aside-*.db"):
            with closing(sqlite3.connect(aside)) as opened:
                if opened.execute("SELECT 1 FROM sqlite_master WHERE name=?", (table,)).fetchone():
                    kept |= {row[:-1] for row in opened.execute(f"SELECT * FROM {table}")}
        assert len(kept) >= count, table  # some were damaged, and made again from the log


@pytest.mark.parametrize(
    ("table", "leaf"), [("trials", True), ("trials", False), ("messages", True), ("notes", False)]
)
def test_what_can_be_read_of_damaged_pages_is_saved_into_a_new_file(
    recorded: Path, table: str, leaf: bool
) -> None:
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


def test_a_file_of_which_nothing_can_be_read_is_left_as_it_is(recorded: Path) -> None:
    change(recorded, "PRAGMA wal_checkpoint(TRUNCATE)")
    with (recorded / FILE).open("rb+") as file:
        file.seek(100)
        file.write(b"\xff" * 3000)
    damaged = (recorded / FILE).read_bytes()
    with pytest.raises(StoreError, match="damaged"):
        repair(recorded)
    assert (recorded / FILE).read_bytes() == damaged
    assert not list(recorded.glob("*.part"))

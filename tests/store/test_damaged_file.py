"""All that SQLite reads is saved of a file that is cut short; what is missing is told."""

import os
import shutil
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.store.database import FILE, connect
from sar_tui.store.integrity import flaws
from sar_tui.store.repair import repair
from tests.examples import first
from tests.played import simulated
from tests.program import Call
from tests.store.by_hand import sql, value

PAGE = 4096
TABLES = ("sessions", "attempts", "trials", "messages")


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data folder with six sessions, in one file."""
    folder = tmp_path_factory.mktemp("whole")
    for seed in range(6):
        simulated(folder, seed=seed, attempts=5, prompts_per_attempt=10)
    sql(folder, "PRAGMA wal_checkpoint(TRUNCATE)")
    return folder


@pytest.fixture
def copy(whole: Path, data: Path) -> Path:
    data.mkdir(parents=True)
    shutil.copyfile(whole / FILE, data / FILE)
    return data


def counts(folder: Path) -> dict[str, int]:
    return {table: value(folder, f"SELECT count(*) FROM {table}") for table in TABLES}


def ids(folder: Path) -> set[str]:
    return {id for (id,) in sql(folder, "SELECT id FROM sessions")}


def overwrite(path: Path, at: int, data: bytes) -> None:
    with path.open("rb+") as file:
        file.seek(at)
        file.write(data)


@pytest.mark.parametrize("share", first(1, [0.5, 0.85]))
def test_what_is_left_of_a_file_cut_short_is_read(share: float, copy: Path, whole: Path) -> None:
    size = int((copy / FILE).stat().st_size * share)
    os.truncate(copy / FILE, size + 17)
    before = counts(whole)
    done = repair(copy)
    assert done.kept
    assert done.kept.stat().st_size == size + 17
    after = counts(copy)
    assert all(after[table] <= before[table] for table in TABLES)
    if share > 0.6:
        assert after["sessions"] >= 0.5 * before["sessions"], done
    lost = ids(whole) - ids(copy)
    told = {each.session for each in done.missing} | {flaw.where for flaw in done.flaws}
    known = told | {name for name in ids(copy) if not _lacks(copy, whole, name)}
    assert ids(copy) <= known, "of each session that is there, what it lacks is told"
    assert done.missing or done.unread
    if share > 0.8:
        assert lost <= told, "a session of which anything is left is named"


def _lacks(folder: Path, whole: Path, session: str) -> bool:
    number = "SELECT number FROM session_numbers WHERE id=?"
    query = f"SELECT count(*) FROM messages WHERE session_number=({number})"
    return bool(value(folder, query, session) < value(whole, query, session))


def test_missing_rows_are_counted_by_session_and_table(copy: Path, whole: Path) -> None:
    """A leaf of messages is zeroed: those of its page are lost, and no others."""
    query = "SELECT pageno FROM dbstat WHERE name='messages' AND pagetype='leaf'"
    leaves = [page for (page,) in sql(whole, query)]
    overwrite(copy / FILE, (leaves[len(leaves) // 2] - 1) * PAGE, bytes(PAGE))
    before = counts(whole)
    done = repair(copy)
    after = counts(copy)
    assert {name for name in TABLES if after[name] != before[name]} == {"messages"}
    lost = before["messages"] - after["messages"]
    assert sum(each.rows for each in done.missing) == lost > 0
    assert {each.table for each in done.missing} == {"messages"}
    assert {flaw.where for flaw in done.flaws} == {each.session for each in done.missing}


def test_a_repair_tells_what_is_missing(copy: Path, call: Call) -> None:
    os.truncate(copy / FILE, int((copy / FILE).stat().st_size * 0.8))
    called = call("check", "--repair", "--data", copy)
    assert "All rows that can be read are in a new file." in called.out
    assert ": Missing: " in called.out


def test_a_rescue_file_that_is_damaged_is_brought_back_as_far_as_it_can_be_read(
    copy: Path, whole: Path, call: Call
) -> None:
    first, *_ = sorted(ids(whole))
    rescue = copy / f"sar-tui-rescue-{first}.db"
    (copy / FILE).rename(rescue)
    os.truncate(rescue, int(rescue.stat().st_size * 0.8))
    called = call("rescue", "--data", copy)
    assert "The file is damaged. Missing: " in called.out
    assert len(ids(copy)) >= 3
    with closing(connect(copy)) as database:
        assert not [flaw for flaw in flaws(database) if flaw.kind == "file"]

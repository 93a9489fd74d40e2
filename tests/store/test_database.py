"""The database is private, durable and up to date, or refused with a reason."""

import os
import sqlite3
import stat
import tempfile
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from sqlite3 import Connection

import pytest
from filelock import FileLock
from msgspec import structs
from sqlite_utils import Database

from sar_tui.store import database as module
from sar_tui.store import tables
from sar_tui.store.database import FILE, StoreError, connect, default_folder, explain, transaction
from sar_tui.store.tables import FIRST_VERSION, VERSION, Column, Table
from tests.program import Call
from tests.store.by_hand import Place, sql, value

NEW = "INSERT INTO participants (code, created_at) VALUES (?, 'now')"


def codes(place: Place) -> list[str]:
    return [code for (code,) in sql(place, "SELECT code FROM participants ORDER BY code")]


_NOBODY = 65534
"""User id of ``nobody``, who owns no files."""
posix = pytest.mark.skipif(os.name != "posix", reason="permissions are those of POSIX")


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


def refusal(folder: Path) -> StoreError:
    with pytest.raises(StoreError) as caught:
        connect(folder)
    assert str(caught.value).endswith(".")
    return caught.value


def pragma(place: Place, name: str) -> object:
    return value(place, f"PRAGMA {name}")


def schema_of(database: Connection) -> tuple[object, ...]:
    """Return all columns of each table in any order, and the text of all views and triggers."""
    tables = Database(database).table_names()
    columns = {
        table: {tuple(row[1:]) for row in database.execute(f"PRAGMA table_info({table})")}
        for table in tables
    }
    others = "SELECT type, name, sql FROM sqlite_master WHERE type IN ('view', 'trigger')"
    indexes = "SELECT name, tbl_name FROM sqlite_master WHERE type='index'"
    return (columns, *(set(database.execute(query)) for query in (others, indexes)))


def test_every_commit_is_synced_to_the_disk_and_a_lost_write_ahead_log_mode_comes_back(
    data: Path,
) -> None:
    sql(data, "PRAGMA journal_mode=DELETE")
    database = connect(data)
    assert (pragma(database, "journal_mode"), pragma(database, "synchronous")) == ("wal", 2)


def test_a_current_database_opens_while_another_holds_the_upgrade_lock(data: Path) -> None:
    connect(data).close()
    with FileLock(data / "sar-tui.lock"):
        assert pragma(data, "user_version") == VERSION
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(module, "_LOCK_TIMEOUT_S", 0)
            patch.setattr(module, "VERSION", VERSION + 1)
            assert "locked" in str(refusal(data))


@posix
def test_the_folder_those_above_and_its_files_are_their_owners_alone_whatever_the_umask(
    tmp_path: Path,
) -> None:
    data = tmp_path / "clinic" / "ward" / "data"
    before = os.umask(0)
    try:
        database = connect(data)
    finally:
        os.umask(before)
    sql(database, NEW, "P01")
    assert [mode(folder) for folder in (data, *data.parents[:2])] == [0o700] * 3
    assert {mode(path) for path in data.iterdir()} == {0o600}
    assert {FILE, f"{FILE}-wal"} <= {path.name for path in data.iterdir()}
    (data / FILE).chmod(0o644)
    connect(data)
    assert mode(data / FILE) == 0o600


def test_a_database_of_a_newer_version_is_refused_and_left_alone(data: Path) -> None:
    sql(data, f"PRAGMA user_version={VERSION + 1}")
    error = refusal(data)
    assert "newer sar-tui" in str(error)
    assert f"data version {VERSION + 1}" in str(error)
    assert error.bad_input
    with closing(sqlite3.connect(data / FILE)) as database:
        assert pragma(database, "user_version") == VERSION + 1


@pytest.mark.parametrize(
    "content",
    [b"hello", b"a diary, not a database\n" * 500, b"SQLite format 2\x00" + b"\x00" * 5000],
)
def test_a_file_that_is_no_database_is_refused_and_unchanged(data: Path, content: bytes) -> None:
    data.mkdir()
    (data / FILE).write_bytes(content)
    error = refusal(data)
    assert f"{data / FILE} is not a SQLite database" in str(error)
    assert error.bad_input
    assert (data / FILE).read_bytes() == content


def test_damaged_pages_and_a_schema_that_is_not_even_text_are_reported(data: Path) -> None:
    text = "CAST('CREATE TABLE ' || x'ff' || '(' AS TEXT)"
    with closing(connect(data)) as database:
        sql(database, "PRAGMA writable_schema=ON")
        sql(database, f"UPDATE sqlite_schema SET sql={text} WHERE name='trials'")
    assert "sar-tui.db is damaged. Restore a backup" in str(refusal(data))
    whole = (data / FILE).read_bytes()
    (data / FILE).write_bytes(whole[:100] + b"\xff" * 4000 + whole[4100:])
    assert refusal(data).bad_input


def test_a_folder_that_is_a_file_is_reported(tmp_path: Path) -> None:
    (tmp_path / "data").write_text("")
    refused = refusal(tmp_path / "data")
    assert "is a file, not a folder" in str(refused)
    assert refused.bad_input


@posix
def test_a_folder_that_is_read_only_is_reported() -> None:
    """The superuser can write anywhere, so the test drops to an ordinary user for a moment."""
    user = os.geteuid()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o555)
        if user == 0:
            os.seteuid(_NOBODY)
        try:
            refused = refusal(folder / "data")
        finally:
            os.seteuid(user)
            folder.chmod(0o700)
    assert "cannot be written to: Permission denied" in str(refused)
    assert not refused.bad_input


def test_a_database_of_an_unreleased_version_is_refused_and_left_unchanged(
    data: Path, call: Call
) -> None:
    connect(data).close()
    with closing(sqlite3.connect(data / FILE)) as database:
        sql(database, "PRAGMA journal_mode=DELETE")
        sql(database, f"PRAGMA user_version={FIRST_VERSION - 1}")
    before = (data / FILE).read_bytes()
    another = data.parent / "another"
    assert call("site BASEL --data", another).code == 0
    merged = f"merge {data / FILE} --site BERN --data {another}"
    for arguments in (
        "sessions",
        "simulate keyboard --user poor",
        "check --repair",
        "backup",
        merged,
    ):
        called = call(arguments)
        assert (called.code, called.err.count("\n")) == (2, 1), (arguments, called)
        assert "export it with the version that wrote it" in called.err
    assert (data / FILE).read_bytes() == before
    (data / FILE).rename(data / "sar-tui-rescue-abc.db")
    called = call("rescue")
    assert (called.code, "export it with the version" in called.err) == (2, True)


def test_a_database_of_another_program_is_refused_and_left_unchanged(data: Path) -> None:
    data.mkdir()
    with closing(sqlite3.connect(data / FILE)) as database:
        database.execute("CREATE TABLE bookmarks (address)")
    before = (data / FILE).read_bytes()
    assert refusal(data).bad_input
    assert (data / FILE).read_bytes() == before


@pytest.fixture
def older(data: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A database of this version, opened by a program of the next one, which declares a further
    column of trials, and a further table.
    """
    sql(data, NEW, "P01")
    column = Column("device_delay_ms", "number", "A test.", since=VERSION + 1)
    wider = structs.replace(tables.TRIALS, columns=(*tables.TRIALS.columns, column))
    goals = Table("goals", "A test", (Column("session", "string", "A test."),), since=VERSION + 1)
    monkeypatch.setitem(tables.TABLES, "trials", wider)
    monkeypatch.setitem(tables.TABLES, "goals", goals)
    for place in (tables, module):
        monkeypatch.setattr(place, "VERSION", VERSION + 1)
    return data


@pytest.mark.parametrize("is_large", [True, False])
def test_an_older_database_is_backed_up_and_upgraded_which_is_announced_if_it_is_large(
    older: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    is_large: bool,
) -> None:
    monkeypatch.setattr(module, "_LARGE_MB", 0.0 if is_large else 1.0)
    opened, new = connect(older), connect(tmp_path / "new")
    assert pragma(opened, "user_version") == VERSION + 1
    assert schema_of(opened) == schema_of(new)
    assert codes(opened) == ["P01"]
    connect(older)  # again: another backup would make this test fail
    assert capsys.readouterr().err.count("is brought up to date for this version") == is_large
    (backup,) = older.glob("*-v*.db")
    assert backup.name.startswith(f"{FILE.removesuffix('.db')}-v{VERSION}-")
    assert os.name != "posix" or mode(backup) == 0o600
    kept = sqlite3.connect(backup)
    assert pragma(kept, "user_version") == VERSION
    assert "goals" not in Database(kept).table_names()
    assert codes(kept) == ["P01"]


def test_an_upgrade_that_fails_changes_nothing(
    older: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with closing(sqlite3.connect(older / FILE)) as database:
        before = list(database.iterdump())
    with monkeypatch.context() as patch:
        patch.setitem(tables.TABLES, "goals", structs.replace(tables.TABLES["goals"], options="?"))
        refusal(older)
    with closing(sqlite3.connect(older / FILE)) as database:
        assert (pragma(database, "user_version"), list(database.iterdump())) == (VERSION, before)
    assert pragma(connect(older), "user_version") == VERSION + 1


def test_threads_that_open_a_new_folder_at_the_same_moment_all_can(data: Path) -> None:
    with ThreadPoolExecutor(8) as pool:
        opened = list(pool.map(lambda _: connect(data), range(8)))
    assert [pragma(database, "user_version") for database in opened] == [VERSION] * 8


def test_a_transaction_that_is_stopped_or_that_the_disk_refuses_changes_nothing(
    database: Connection,
) -> None:
    def half() -> None:
        with transaction(database) as connection:
            sql(connection, NEW, "P01")
            raise KeyboardInterrupt

    def too_much() -> None:
        with transaction(database) as connection:
            sql(connection, NEW, "P01")
            sql(connection, "INSERT INTO notes (session, text) VALUES ('s', zeroblob(1000000))")

    with pytest.raises(KeyboardInterrupt):
        half()
    assert codes(database) == []
    sql(database, f"PRAGMA max_page_count={pragma(database, 'page_count')}")
    with pytest.raises(StoreError, match="The disk is full"):
        too_much()
    assert codes(database) == []
    with transaction(database) as connection:
        sql(connection, NEW, "P02")
    assert codes(database) == ["P02"]


def test_the_environment_sets_the_data_folder(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("SAR_TUI_DATA", str(tmp_path))
    assert default_folder() == tmp_path
    monkeypatch.delenv("SAR_TUI_DATA")
    assert default_folder().name == "sar-tui"


TEMPORARY = "FULL IOERR_FSYNC BUSY_SNAPSHOT READONLY CANTOPEN NOMEM".split()


@pytest.mark.parametrize("name", [*TEMPORARY, "CORRUPT", "CONSTRAINT_PRIMARYKEY", None])
def test_temporary_and_permanent_errors_are_told_apart(name: str | None) -> None:
    error = sqlite3.OperationalError("refused")
    if name is not None:
        error.sqlite_errorcode = getattr(sqlite3, f"SQLITE_{name}")
    explained = explain(error, Path("x.db"))
    assert explained.temporary is (name in TEMPORARY)
    unforeseen = name in ("CONSTRAINT_PRIMARYKEY", None)
    assert (str(explained) == "x.db: refused.") is unforeseen

"""The database is private, durable and up to date, or refused with a reason."""

import os
import shutil
import sqlite3
import stat
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import pytest
from filelock import FileLock
from msgspec import structs
from sqlite_utils import Database

from sar_tui.store import database as module
from sar_tui.store import tables
from sar_tui.store.database import (
    FILE,
    StoreError,
    connect,
    default_folder,
    explain,
    transaction,
)
from sar_tui.store.tables import FIRST_VERSION, VERSION, Column, Table
from tests.program import Call

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


def pragma(database: sqlite3.Connection, name: str) -> object:
    return database.execute(f"PRAGMA {name}").fetchone()[0]


def schema_of(database: sqlite3.Connection) -> tuple[object, ...]:
    """Return all columns of each table in any order, and the text of all views and triggers."""
    tables = Database(database).table_names()
    columns = {
        table: {tuple(row[1:]) for row in database.execute(f"PRAGMA table_info({table})")}
        for table in tables
    }
    others = "SELECT type, name, sql FROM sqlite_master WHERE type IN ('view', 'trigger')"
    indexes = "SELECT name, tbl_name FROM sqlite_master WHERE type='index'"
    return (columns, *(set(database.execute(query)) for query in (others, indexes)))


def test_every_commit_is_synced_to_the_disk(database: sqlite3.Connection) -> None:
    assert (pragma(database, "journal_mode"), pragma(database, "synchronous")) == ("wal", 2)


def test_a_current_database_opens_while_another_program_holds_the_lock_of_migrations(
    data: Path,
) -> None:
    connect(data).close()
    with FileLock(data / "sar-tui.lock"):
        with closing(connect(data)) as database:
            assert pragma(database, "user_version") == VERSION
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(module, "_LOCK_TIMEOUT_S", 0)
            patch.setattr(module, "VERSION", VERSION + 1)
            assert "locked" in str(refusal(data))


def test_a_current_database_that_lost_its_write_ahead_log_mode_gets_it_back(data: Path) -> None:
    connect(data).close()
    with closing(sqlite3.connect(data / FILE)) as restored:
        restored.execute("PRAGMA journal_mode=DELETE")
    with closing(connect(data)) as database:
        assert pragma(database, "journal_mode") == "wal"


@posix
def test_the_folder_and_every_file_in_it_are_its_owners_alone(
    database: sqlite3.Connection, data: Path
) -> None:
    Database(database)["notes"].insert({"session": "s", "text": "x"})
    assert mode(data) == 0o700
    assert {path.name: oct(mode(path)) for path in data.iterdir()} == {
        path.name: oct(0o600) for path in data.iterdir()
    }
    assert (data / FILE).exists()
    assert (data / f"{FILE}-wal").exists()


@posix
def test_a_database_that_others_could_read_is_made_private(
    database: sqlite3.Connection, data: Path
) -> None:
    (data / FILE).chmod(0o644)
    connect(data)
    assert mode(data / FILE) == 0o600


def test_opening_a_database_again_keeps_its_rows(database: sqlite3.Connection, data: Path) -> None:
    Database(database)["participants"].insert({"code": "P01", "created_at": "now"})
    assert [row["code"] for row in Database(connect(data))["participants"].rows] == ["P01"]
    assert list(data.glob("*-v*.db")) == []


def test_a_database_of_a_newer_version_is_refused_and_left_alone(data: Path) -> None:
    connect(data).execute(f"PRAGMA user_version={VERSION + 1}")
    error = refusal(data)
    assert "newer sar-tui" in str(error)
    assert f"data version {VERSION + 1}" in str(error)
    assert error.bad_input
    assert sqlite3.connect(data / FILE).execute("PRAGMA user_version").fetchone() == (VERSION + 1,)


@pytest.mark.parametrize(
    "content",
    [b"hello", b"a diary, not a database\n" * 500, b"SQLite format 2\x00" + b"\x00" * 5000],
)
def test_a_file_that_is_not_a_database_is_refused_and_left_unchanged(
    data: Path, content: bytes
) -> None:
    data.mkdir()
    (data / FILE).write_bytes(content)
    error = refusal(data)
    assert f"{data / FILE} is not a SQLite database" in str(error)
    assert error.bad_input
    assert (data / FILE).read_bytes() == content


def test_a_damaged_database_is_reported(data: Path) -> None:
    connect(data).close()
    whole = (data / FILE).read_bytes()
    (data / FILE).write_bytes(whole[:100] + b"\xff" * 4000 + whole[4100:])
    assert refusal(data).bad_input


def test_a_schema_that_is_not_even_text_is_reported_as_damage(data: Path) -> None:
    with closing(connect(data)) as database:
        database.execute("PRAGMA writable_schema=ON")
        database.execute(
            "UPDATE sqlite_schema SET sql=CAST('CREATE TABLE ' || x'ff' || '(' AS TEXT) WHERE "
            "name='trials'"
        )
    assert "sar-tui.db is damaged. Restore a backup" in str(refusal(data))


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


@posix
def test_the_folders_above_are_private_too_whatever_the_umask(tmp_path: Path) -> None:
    before = os.umask(0)
    try:
        connect(tmp_path / "clinic" / "ward" / "data").close()
    finally:
        os.umask(before)
    folders = [
        tmp_path / "clinic",
        tmp_path / "clinic" / "ward",
        tmp_path / "clinic" / "ward" / "data",
    ]
    assert [mode(folder) for folder in folders] == [0o700] * 3


@pytest.mark.parametrize("version", [1, 22, FIRST_VERSION - 1])
def test_a_database_of_an_unreleased_version_is_refused_and_left_unchanged(
    data: Path, call: Call, version: int
) -> None:
    connect(data).close()
    with closing(sqlite3.connect(data / FILE)) as database:
        database.execute("PRAGMA journal_mode=DELETE")
        database.execute(f"PRAGMA user_version={version}")
    before = (data / FILE).read_bytes()
    another = data.parent / "another"
    assert call("site", "BASEL", "--data", another).code == 0
    for arguments in (
        ("sessions",),
        ("show", "last"),
        ("simulate", "keyboard", "--user", "poor"),
        ("check",),
        ("check", "--repair"),
        ("backup",),
        ("merge", data / FILE, "--site", "BERN", "--data", another),
    ):
        called = call(*arguments)
        assert (called.code, called.err.count("\n")) == (2, 1), (arguments, called)
        assert "export it with the version that wrote it" in called.err
    assert (data / FILE).read_bytes() == before


def test_a_rescue_file_of_an_unreleased_version_is_refused(data: Path, call: Call) -> None:
    connect(data).close()
    shutil.copyfile(data / FILE, data / "sar-tui-rescue-abc.db")
    with closing(sqlite3.connect(data / "sar-tui-rescue-abc.db")) as database:
        database.execute("PRAGMA user_version=22")
    called = call("rescue")
    assert called.code == 2
    assert "export it with the version that wrote it" in called.err


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
    with closing(connect(data)) as opened:
        opened.execute("INSERT INTO participants (code, created_at) VALUES ('P01', 'now')")
    column = Column("device_delay_ms", "number", "A test.", since=VERSION + 1)
    wider = structs.replace(tables.TRIALS, columns=(*tables.TRIALS.columns, column))
    goals = Table("goals", "A test", (Column("session", "string", "A test."),), since=VERSION + 1)
    monkeypatch.setitem(tables.TABLES, "trials", wider)
    monkeypatch.setitem(tables.TABLES, "goals", goals)
    monkeypatch.setattr(tables, "VERSION", VERSION + 1)
    monkeypatch.setattr(module, "VERSION", VERSION + 1)
    return data


def test_an_older_database_gets_what_was_declared_since_after_a_backup(
    older: Path, tmp_path: Path
) -> None:
    opened, new = connect(older), connect(tmp_path / "new")
    assert pragma(opened, "user_version") == VERSION + 1
    assert schema_of(opened) == schema_of(new)
    assert [row["code"] for row in Database(opened)["participants"].rows] == ["P01"]
    (backup,) = older.glob(f"*-v{VERSION}-*.db")
    kept = Database(sqlite3.connect(backup))
    assert pragma(kept, "user_version") == VERSION
    assert "goals" not in kept.table_names()
    assert [row["code"] for row in kept["participants"].rows] == ["P01"]


def test_an_upgrade_that_fails_leaves_the_database_as_it_was(
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


@pytest.mark.parametrize("is_large", [True, False])
def test_it_is_announced_that_a_large_database_is_brought_up_to_date(
    older: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], is_large: bool
) -> None:
    monkeypatch.setattr(module, "_LARGE_MB", 0.0 if is_large else 1.0)
    connect(older)
    connect(older)
    assert capsys.readouterr().err.count(
        "is brought up to date for this version of sar-tui. A copy of it is kept."
    ) == (1 if is_large else 0)


@posix
def test_the_backup_is_as_private_as_the_database(older: Path) -> None:
    connect(older)
    (backup,) = older.glob("*-v*.db")
    assert mode(backup) == 0o600


def test_it_is_upgraded_and_backed_up_once(older: Path) -> None:
    for _ in range(3):
        connect(older)
    assert len(list(older.glob("*-v*.db"))) == 1


def test_programs_that_open_a_new_folder_at_the_same_moment_all_can(data: Path) -> None:
    opens = (
        "import sys; from pathlib import Path; from sar_tui.store.database import connect; "
        "connect(Path(sys.argv[1]))"
    )

    def program(_: int) -> str:
        run = subprocess.run(
            [sys.executable, "-c", opens, str(data)], capture_output=True, text=True, check=False
        )
        return run.stderr

    with ThreadPoolExecutor(3) as pool:
        assert list(pool.map(program, range(3))) == [""] * 3


def test_threads_that_open_a_new_folder_at_the_same_moment_all_can(data: Path) -> None:
    with ThreadPoolExecutor(8) as pool:
        assert [
            pragma(db, "user_version") for db in pool.map(lambda _: connect(data), range(8))
        ] == [VERSION] * 8


_A_PROGRAM = """
import os, sys
from pathlib import Path
from sar_tui.store.database import connect
folder = Path(sys.argv[1])
first, second = connect(folder), connect(folder)
for line in sys.stdin:
    second.execute("INSERT INTO participants (code, created_at) VALUES (?, 'now')", (line.strip(),))
    print("stored", flush=True)
"""


def test_committed_data_survive_kill_9_and_are_visible_to_other_programs(data: Path) -> None:
    """As a session does, the program has the database open twice."""
    look = (
        "import sqlite3, sys; c = sqlite3.connect(sys.argv[1]); print(*c.execute('SELECT code "
        "FROM participants'))"
    )

    def seen_by_another() -> str:
        done = subprocess.run(
            [sys.executable, "-c", look, str(data / FILE)],
            capture_output=True,
            text=True,
            check=True,
        )
        return done.stdout.strip()

    program = subprocess.Popen(
        [sys.executable, "-c", _A_PROGRAM, str(data)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    with program:
        assert program.stdin
        assert program.stdout
        codes = []
        for code in ("P01", "P02", "P03"):
            print(code, file=program.stdin, flush=True)
            assert program.stdout.readline() == "stored\n"
            codes.append(f"('{code}',)")
            assert seen_by_another() == " ".join(codes)
        program.kill()
    assert seen_by_another() == " ".join(codes)


def test_a_transaction_is_all_or_nothing(database: sqlite3.Connection) -> None:
    def half() -> None:
        with transaction(database) as connection:
            connection.execute("INSERT INTO participants (code, created_at) VALUES ('P01', 'now')")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        half()
    assert list(Database(database)["participants"].rows) == []
    with transaction(database) as connection:
        connection.execute("INSERT INTO participants (code, created_at) VALUES ('P02', 'now')")
    assert [row["code"] for row in Database(database)["participants"].rows] == ["P02"]


def test_a_transaction_that_the_disk_refuses_changes_nothing_and_says_why(
    database: sqlite3.Connection,
) -> None:
    def too_much() -> None:
        with transaction(database) as connection:
            connection.execute("INSERT INTO participants (code, created_at) VALUES ('P01', 'now')")
            connection.execute("INSERT INTO notes (session, text) VALUES ('s', zeroblob(1000000))")

    pages = pragma(database, "page_count")
    database.execute(f"PRAGMA max_page_count={pages}")
    with pytest.raises(StoreError, match="The disk is full"):
        too_much()
    assert list(Database(database)["participants"].rows) == []
    with transaction(database) as connection:
        connection.execute("INSERT INTO participants (code, created_at) VALUES ('P02', 'now')")


def test_a_file_beside_the_database_that_may_not_be_written_to_is_named() -> None:
    error = sqlite3.OperationalError("attempt to write a readonly database")
    error.sqlite_errorcode = sqlite3.SQLITE_READONLY
    assert "sar-tui.db-wal and sar-tui.db-shm, which another user may have left" in str(
        explain(error)
    )


def test_the_data_folder_can_be_set_by_an_environment_variable(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("SAR_TUI_DATA", str(tmp_path))
    assert default_folder() == tmp_path
    monkeypatch.delenv("SAR_TUI_DATA")
    assert default_folder().name == "sar-tui"


def test_an_unforeseen_error_is_reported_in_sqlites_own_words() -> None:
    assert (
        str(explain(sqlite3.OperationalError("no such thing"), Path("x.db")))
        == "x.db: no such thing."
    )


@pytest.mark.parametrize(
    ("code", "temporary"),
    [
        (sqlite3.SQLITE_FULL, True),
        (sqlite3.SQLITE_IOERR_FSYNC, True),
        (sqlite3.SQLITE_BUSY_SNAPSHOT, True),
        (sqlite3.SQLITE_READONLY, True),
        (sqlite3.SQLITE_CANTOPEN, True),
        (sqlite3.SQLITE_NOMEM, True),
        (sqlite3.SQLITE_CORRUPT, False),
        (sqlite3.SQLITE_CONSTRAINT_PRIMARYKEY, False),
        (None, False),
    ],
)
def test_temporary_and_permanent_errors_are_reported_apart(
    code: int | None, temporary: bool
) -> None:
    error = sqlite3.OperationalError("refused")
    if code is not None:
        error.sqlite_errorcode = code
    assert explain(error).temporary is temporary


def test_a_copy_of_the_database_is_a_whole_database(
    database: sqlite3.Connection, data: Path, tmp_path: Path
) -> None:
    Database(database)["participants"].insert({"code": "P01", "created_at": "now"})
    shutil.copytree(data, tmp_path / "copy")
    copy = connect(tmp_path / "copy")
    assert pragma(copy, "integrity_check") == "ok"
    assert [row["code"] for row in Database(copy)["participants"].rows] == ["P01"]

"""``sar-tui rescue`` brings rescue files back; every command says that they wait, and that data was
lost.
"""

import re
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.cli.common import Home
from sar_tui.cli.doctor import machine
from sar_tui.cli.doctor.finding import Finding, Machine
from sar_tui.outputs.sound.protocol import Examined
from sar_tui.store import sessions
from sar_tui.store.database import FILE, connect
from sar_tui.store.rescue import rescue_files
from tests.program import Call
from tests.store.test_last_saved import crashed
from tests.store.test_rescue import rescued

__all__ = ["crashed"]


@pytest.fixture
def waiting(tmp_path: Path) -> str:
    """A session in a rescue file, whose database was removed; its id."""
    return rescued(tmp_path / "data").id


def saved_data(folder: Path) -> Finding:
    return machine.saved_data(Machine(Home(folder), Examined))


def test_without_rescue_files_there_is_nothing_to_do(call: Call, tmp_path: Path) -> None:
    called = call("rescue")
    assert (called.code, called.out) == (0, f"There are no rescue files in {tmp_path / 'data'}.\n")
    assert call("rescue --json").json == {"sessions": []}


def test_a_rescue_file_is_brought_back(call: Call, waiting: str) -> None:
    called = call("rescue")
    assert (called.code, called.out) == (
        0,
        f"Session {waiting} of P01 (keyboard) is in the database again.\n",
    )
    listed = call("sessions --json")
    assert [row["id"] for row in listed.json["sessions"]] == [waiting]
    assert listed.err == ""
    assert call("rescue").out.startswith("There are no rescue files")


def test_a_file_that_holds_nothing_new_is_put_away(
    call: Call, waiting: str, tmp_path: Path
) -> None:
    (path,) = rescue_files(tmp_path / "data")
    call("rescue")
    (done,) = (tmp_path / "data").glob("sar-tui-rescued-*.db")
    done.rename(path)
    assert call("rescue").out == "The database has all that is in the rescue files.\n"
    assert rescue_files(tmp_path / "data") == []


def test_a_session_that_went_on_differently_stays_in_its_file(
    call: Call, waiting: str, tmp_path: Path
) -> None:
    (path,) = rescue_files(tmp_path / "data")
    with closing(connect(tmp_path / "data")) as database:
        facts: Any = {
            "theme": "calm",
            "seed": 1,
            "parameters": {},
            "software": {},
            "machine": {},
            "mode": "live",
        }
        sessions.create(database, waiting, task="keyboard", participant="P01", **facts)
        for _ in range(2):
            sessions.begin_run(database, waiting, software={}, machine={})
    called = call("rescue")
    assert called.code == 1
    assert called.out == (
        f"Session {waiting} of P01 (keyboard) stays in {path}: it was resumed in the database "
        "since, and went on "
        "differently.\n"
    )


def damage(data: Path, change: str) -> Path:
    """Change the rescue file, and return it."""
    (path,) = rescue_files(data)
    with closing(sqlite3.connect(path)) as database:
        database.execute(change)
        database.commit()
    return path


@pytest.mark.parametrize(
    "change",
    [
        "UPDATE messages SET topic=9999 WHERE seq=7",
        "UPDATE messages SET message='[1, ' WHERE seq=7",
        "UPDATE messages SET message=CAST(x'5B22FF225D' AS TEXT) WHERE seq=7",
    ],
    ids=["topic", "text", "bytes"],
)
def test_damaged_messages_are_named_and_the_others_brought_back(
    call: Call, waiting: str, tmp_path: Path, change: str
) -> None:
    damage(tmp_path / "data", change)
    called = call("rescue")
    assert (called.code, called.err) == (0, "")
    assert "! Messages of it that are damaged are left out: 1 (number 7)." in called.out
    with closing(connect(tmp_path / "data")) as database:
        (count, last) = database.execute("SELECT count(*), max(seq) FROM events").fetchone()
    assert count == last - 1


@pytest.mark.parametrize(
    ("change", "who"),
    [
        ("UPDATE sessions SET parameters='{'", "P01"),
        ("UPDATE trials SET response=CAST(x'FF' AS TEXT)", "P01"),
        ("UPDATE seats SET session='another'", "?"),
    ],
)
def test_a_session_with_a_damaged_row_stays_in_its_file(
    call: Call, waiting: str, tmp_path: Path, change: str, who: str
) -> None:
    path = damage(tmp_path / "data", change)
    called = call("rescue")
    assert (called.code, called.err) == (1, "")
    assert (
        f"Session {waiting} of {who} (keyboard) stays in {path}: its rows are damaged" in called.out
    )
    assert call("sessions").code == 0


@pytest.mark.parametrize("command", [["sessions"], ["show", "last"]])
def test_commands_say_that_a_rescue_file_waits(
    call: Call, waiting: str, tmp_path: Path, command: list[str]
) -> None:
    (path,) = rescue_files(tmp_path / "data")
    assert call(*command).err.startswith(
        f"! {path} holds data that is not in the database. `sar-tui rescue` brings it back.\n"
    )


def test_a_session_is_not_resumed_while_its_last_messages_are_in_a_rescue_file(
    call: Call, waiting: str, tmp_path: Path
) -> None:
    (path,) = rescue_files(tmp_path / "data")
    with closing(sqlite3.connect(path)) as source, closing(connect(tmp_path / "data")) as database:
        source.backup(database)
        database.execute("UPDATE sessions SET status='interrupted'")
    called = call("resume", waiting)
    assert called.code == 2
    assert (
        f"The last messages of session {waiting} are in {path}. Run `sar-tui rescue` first."
        in called.err
    )


def test_commands_and_doctor_say_that_data_was_lost(call: Call, crashed: Path) -> None:
    (crashed / f"{FILE}-wal").unlink()
    assert call("sessions --data", crashed).err.startswith("! Data was lost: session ")
    finding = saved_data(crashed)
    assert finding.state == "bad"
    assert "was saved up to attempt 2, trial 1" in finding.found
    assert "Restore a backup, or delete " in finding.advice


def test_doctor_reports_rescue_files(call: Call, waiting: str, tmp_path: Path) -> None:
    finding = saved_data(tmp_path / "data")
    assert (finding.state, finding.advice) == ("bad", "Run `sar-tui rescue`, which brings it back.")
    call("rescue")
    assert saved_data(tmp_path / "data").state == "ok"
    assert saved_data(tmp_path / "none").state == "ok"


def test_beside_a_damaged_database_the_file_and_what_is_in_it_are_named(
    call: Call, waiting: str, tmp_path: Path
) -> None:
    (path,) = rescue_files(tmp_path / "data")
    held = path.read_bytes()
    (tmp_path / "data" / FILE).write_bytes(b"no database" * 1000)
    called = call("rescue")
    assert (called.code, called.out) == (2, "")
    said, why = called.err.splitlines()
    begins = f"! {path} waits, and is kept as it is. It holds session {waiting} of P01 (keyboard), "
    assert said.startswith(begins)
    assert re.fullmatch(r"\d+ trials?\.", said.removeprefix(begins))
    assert str(tmp_path / "data" / FILE) in why
    assert path.read_bytes() == held

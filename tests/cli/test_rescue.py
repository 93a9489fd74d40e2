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


def test_a_rescue_file_is_brought_back(call: Call, waiting: str, data: Path) -> None:
    finding = saved_data(data)
    assert (finding.state, finding.advice) == ("bad", "Run `sar-tui rescue`, which brings it back.")
    (path,) = rescue_files(data)
    waits = f"! {path} holds data that is not in the database. `sar-tui rescue` brings it back.\n"
    for command in ("sessions", "show last"):
        assert call(command).err.startswith(waits)
    call("rescue").shows(f"Session {waiting} of P01 (keyboard) is in the database again.\n")
    listed = call("sessions --json")
    assert [row["id"] for row in listed.json["sessions"]] == [waiting]
    assert (listed.err, saved_data(data).state) == ("", "ok")
    call("rescue").shows(f"There are no rescue files in {data}.\n")
    assert call("rescue --json").json == {"sessions": []}
    assert saved_data(data / "none").state == "ok"
    (done,) = data.glob("sar-tui-rescued-*.db")
    done.rename(path)
    call("rescue").shows("The database has all that is in the rescue files.\n")
    assert rescue_files(data) == [], "a file that holds nothing new is put away"


def test_a_session_that_went_on_differently_stays_in_its_file(
    call: Call, waiting: str, data: Path
) -> None:
    (path,) = rescue_files(data)
    ran: Any = {"software": {}, "machine": {}}
    facts: Any = {"theme": "calm", "seed": 1, "parameters": {}, "mode": "live", **ran}
    with closing(connect(data)) as database:
        sessions.create(database, waiting, task="keyboard", participant="P01", **facts)
        for _ in range(2):
            sessions.begin_run(database, waiting, **ran)
    said = f"Session {waiting} of P01 (keyboard) stays in {path}: it was resumed in the database"
    call("rescue").shows(said, code=1)


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
        "UPDATE messages SET message=CAST(x'5B22FF225D' AS TEXT) WHERE seq=7",
    ],
    ids=["topic", "bytes"],
)
@pytest.mark.usefixtures("waiting")
def test_damaged_messages_are_named_and_the_others_brought_back(
    call: Call, data: Path, change: str
) -> None:
    damage(data, change)
    call("rescue").shows("! Messages of it that are damaged are left out: 1 (number 7).")
    with closing(connect(data)) as database:
        (count, last) = database.execute("SELECT count(*), max(seq) FROM events").fetchone()
    assert count == last - 1


@pytest.mark.parametrize(
    ("change", "who"),
    [
        ("UPDATE trials SET response=CAST(x'FF' AS TEXT)", "P01"),
        ("UPDATE seats SET session='another'", "?"),
    ],
)
def test_a_session_with_a_damaged_row_stays_in_its_file(
    call: Call, waiting: str, data: Path, change: str, who: str
) -> None:
    path = damage(data, change)
    said = f"Session {waiting} of {who} (keyboard) stays in {path}: its rows are damaged"
    call("rescue").shows(said, code=1)
    assert call("sessions").code == 0


def test_a_session_is_not_resumed_while_its_last_messages_are_in_a_rescue_file(
    call: Call, waiting: str, data: Path
) -> None:
    (path,) = rescue_files(data)
    with closing(sqlite3.connect(path)) as source, closing(connect(data)) as database:
        source.backup(database)
        database.execute("UPDATE sessions SET status='interrupted'")
    said = f"The last messages of session {waiting} are in {path}. Run `sar-tui rescue` first."
    call("resume", waiting).refused(said)


def test_commands_and_doctor_say_that_data_was_lost(call: Call, crashed: Path) -> None:
    (crashed / f"{FILE}-wal").unlink()
    assert call("sessions --data", crashed).err.startswith("! Data was lost: session ")
    finding = saved_data(crashed)
    assert finding.state == "bad"
    assert "was saved up to attempt 2, trial 1" in finding.found
    assert "Restore a backup, or delete " in finding.advice


def test_beside_a_damaged_database_the_file_and_what_is_in_it_are_named(
    call: Call, waiting: str, data: Path
) -> None:
    (path,) = rescue_files(data)
    held = path.read_bytes()
    (data / FILE).write_bytes(b"no database" * 1000)
    called = call("rescue")
    begins = f"! {path} waits, and is kept as it is. It holds session {waiting} of P01 (keyboard), "
    called.refused(begins, str(data / FILE))
    said, _ = called.err.splitlines()
    assert re.fullmatch(r"\d+ trials?\.", said.removeprefix(begins))
    assert path.read_bytes() == held

"""A session whose database is removed, replaced or locked goes on in a rescue file, which can be
brought back.
"""

import os
import shutil
import sqlite3
import stat
from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import pytest

from sar_tui.loop.topics import STORAGE, STORED, TRIAL, WAITING
from sar_tui.store import participants, programmes, sessions
from sar_tui.store.database import (
    FILE,
    Moved,
    StoreConnection,
    StoreError,
    connect,
    open_file,
    transaction,
)
from sar_tui.store.integrity import flaws
from sar_tui.store.programmes import Programme
from sar_tui.store.rescue import bring_back, rescue_files
from sar_tui.store.safeguard import Safeguard
from tests.store.test_recorder import Recorded

pytestmark = pytest.mark.skipif(
    os.name != "posix", reason="Windows does not remove a file that is open"
)


def delete(data: Path) -> None:
    for path in data.glob(f"{FILE}*"):
        path.unlink()


def replace(data: Path) -> None:
    """Restore a backup: another database in the place of this one."""
    delete(data)
    other = data.with_name("other")
    connect(other).close()
    shutil.copy(other / FILE, data / FILE)


def move_away(data: Path) -> None:
    data.rename(data.with_name("elsewhere"))


def delete_the_log(data: Path) -> None:
    (data / f"{FILE}-wal").unlink()


def empty(data: Path) -> None:
    (data / FILE).write_bytes(b"")


class Safe(Recorded):
    """A session whose recorder has a safeguard, as in a live session; its thread is called by the
    test.
    """

    def __init__(self, data: Path, **parameters: Any) -> None:
        super().__init__(data, inline=False, attempts=2, prompts_per_attempt=3, **parameters)
        self.data = data
        self.safeguard = self.recorder.safeguard = Safeguard(data, self.id, self.database)
        self.session.begin()

    def to_trial(self, number: int) -> None:
        """Continue until this many trials are acknowledged."""
        while len(self.all(STORED)) < number:
            if self.all(WAITING)[-1].what == "storage":
                self.write_on_a_thread()
                self.clock.advance(0)
            else:
                assert self.step()

    @property
    def rescue(self) -> sqlite3.Connection:
        (path,) = rescue_files(self.data)
        return open_file(path)


@pytest.mark.parametrize("happens", [delete, replace, move_away, delete_the_log, empty])
def test_a_session_whose_database_is_gone_goes_on_in_a_rescue_file_with_all_that_was_in_it(
    data: Path, happens: Callable[[Path], None]
) -> None:
    database = connect(data)
    participants.add(database, "P09")
    recorded = Safe(data)
    recorded.to_trial(2)
    happens(data)
    recorded.to_trial(4)
    recorded.recorder.write()
    with closing(recorded.rescue) as rescue:
        assert list(sessions.history(rescue, recorded.id)) == recorded.records
        assert len(sessions.rows(rescue, "trials", recorded.id)) == len(recorded.all(STORED)) == 4
        if happens is not empty:  # its pages can be read by nobody
            assert participants.codes(rescue) == ["P09"]


def test_the_experimenter_is_told_and_the_trial_is_repeated(data: Path) -> None:
    recorded = Safe(data)
    recorded.to_trial(1)
    recorded.until(lambda: recorded.all(WAITING)[-1].what == "response")
    delete(data)
    recorded.write_on_a_thread()
    recorded.clock.advance(0)
    (changed,) = recorded.all(STORAGE)
    (path,) = rescue_files(data)
    assert changed.working
    assert (
        changed.reason
        == f"{data / FILE} was removed while it was in use. The session goes on in {path}."
    )
    waiting = recorded.all(WAITING)[-1]
    assert (waiting.stage, waiting.reason, waiting.detail) == ("paused", "restored", changed.reason)


def test_a_database_that_is_damaged_is_left_and_what_could_not_be_read_is_said(data: Path) -> None:
    recorded = Safe(data)
    recorded.to_trial(2)
    saved = len(recorded.history)
    size = (data / FILE).stat().st_size
    for name in (FILE, f"{FILE}-wal"):
        with (data / name).open("r+b") as file:
            file.write(b"\xff" * (data / name).stat().st_size)
    assert (data / FILE).stat().st_size == size
    recorded.database.execute("PRAGMA shrink_memory")
    recorded.to_trial(4)
    recorded.recorder.write()
    assert (
        "is damaged." in recorded.safeguard.text
        or "is not a SQLite database." in recorded.safeguard.text
    )
    assert recorded.safeguard.text.endswith(" What was done before that is not in it.")
    with closing(recorded.rescue) as rescue:
        assert list(sessions.history(rescue, recorded.id)) == recorded.records[saved:]
        assert len(sessions.rows(rescue, "trials", recorded.id)) == 2


def test_what_followed_is_added_to_what_the_database_has(
    data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As when a disk is taken away during a session, and comes back."""
    recorded = Safe(data)
    recorded.to_trial(2)
    away = data.with_name("away")
    data.rename(away)

    def unreadable(*_: object) -> StoreConnection:
        target = open_file(data / f"sar-tui-rescue-{recorded.id}.db")
        recorded.safeguard._rescue._copy_facts(target)
        return target

    monkeypatch.setattr(recorded.safeguard._rescue, "copy_all", unreadable)
    recorded.to_trial(6)
    while recorded.step():
        pass
    recorded.recorder.run(lambda: True)
    recorded.reader.close()
    (rescue,) = rescue_files(data)
    rescue.rename(away / rescue.name)
    shutil.rmtree(data)
    away.rename(data)
    (brought,) = bring_back(data)
    assert brought.problem == ""
    with closing(connect(data)) as database:
        assert list(sessions.history(database, recorded.id)) == recorded.records
        assert len(sessions.rows(database, "trials", recorded.id)) == 6
        assert sessions.stored_status(database, recorded.id) == "completed"
        assert [flaw for flaw in flaws(database) if flaw.kind in ("log", "rows")] == []


def test_a_file_system_whose_file_numbers_change_does_not_fill_up(
    data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def changed(_: StoreConnection) -> None:
        raise Moved("It was replaced.")

    recorded = Safe(data)
    recorded.to_trial(1)
    monkeypatch.setattr(StoreConnection, "check", changed)
    for _ in range(20):
        with suppress(Moved):
            recorded.recorder.write()
    assert len(rescue_files(data)) == 5


def test_a_rescue_file_is_private(data: Path) -> None:
    recorded = Safe(data)
    recorded.to_trial(1)
    delete(data)
    before = os.umask(0)
    try:
        recorded.to_trial(2)
    finally:
        os.umask(before)
    (path,) = rescue_files(data)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_a_trial_is_not_acknowledged_while_it_can_be_written_nowhere(
    data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorded = Safe(data)
    recorded.to_trial(1)
    delete(data)
    with monkeypatch.context() as patched:

        def refuse(_: StoreConnection) -> StoreConnection:
            raise StoreError("The disk is full.", temporary=True)

        patched.setattr(recorded.safeguard._rescue, "copy_all", refuse)
        recorded.until(lambda: len(recorded.all(TRIAL)) == 2)
        recorded.write_on_a_thread()
        recorded.clock.advance(0)
        assert recorded.all(STORAGE)[-1].reason == "The disk is full."
        assert len(recorded.all(STORED)) == 1
        assert recorded.recorder.pending > 0
    recorded.write_on_a_thread()
    recorded.clock.advance(0)
    assert len(recorded.all(STORED)) == 2
    with closing(recorded.rescue) as rescue:
        assert len(sessions.rows(rescue, "trials", recorded.id)) == 2


def test_a_rescue_file_that_is_removed_too_is_followed_by_another(data: Path) -> None:
    recorded = Safe(data)
    recorded.to_trial(1)
    delete(data)
    recorded.to_trial(2)
    (first,) = rescue_files(data)
    for path in data.glob(f"{first.name}*"):
        path.unlink()
    recorded.to_trial(3)
    recorded.recorder.write()
    with closing(recorded.rescue) as rescue:
        assert list(sessions.history(rescue, recorded.id)) == recorded.records


def test_a_write_to_a_database_that_was_removed_is_refused(data: Path) -> None:
    database = connect(data)
    participants.add(database, "P01")
    delete(data)
    with pytest.raises(Moved, match="was removed while it was in use"):
        participants.add(database, "P02")


# --- a database that is locked at the end


@pytest.fixture
def locked(data: Path) -> Safe:
    """A session whose database another program keeps locked, with messages that were not
    written.
    """
    recorded = Safe(data)
    recorded.to_trial(2)
    recorded.database.execute("PRAGMA busy_timeout=0")
    recorded.reader.execute("BEGIN IMMEDIATE")
    recorded.until(lambda: len(recorded.all(TRIAL)) == 3)
    return recorded


def test_what_a_locked_database_refuses_at_the_end_is_in_a_rescue_file(
    data: Path, locked: Safe
) -> None:
    locked.recorder.run(lambda: True)
    assert locked.recorder.pending == 0
    assert "keeps sar-tui.db locked" in locked.safeguard.text
    with closing(locked.rescue) as rescue:
        assert list(sessions.history(rescue, locked.id)) == locked.records
        assert len(sessions.rows(rescue, "trials", locked.id)) == 3


def test_a_short_lock_is_waited_for_without_a_word_and_a_long_one_is_reported(locked: Safe) -> None:
    locked.write_on_a_thread()
    locked.clock.advance(0)
    assert locked.all(STORAGE) == []
    for _ in range(10):
        locked.write_on_a_thread()
    locked.clock.advance(0)
    assert [changed.working for changed in locked.all(STORAGE)] == [False]


def test_without_room_for_a_rescue_file_none_is_left(
    data: Path, locked: Safe, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise StoreError("The disk is full.", temporary=True)

    monkeypatch.setattr("sar_tui.store.rescue.copy_session", refuse)
    locked.recorder.run(lambda: True)
    assert (locked.recorder.pending > 0, locked.safeguard.text) == (True, "")
    assert rescue_files(data) == []
    assert list(data.glob("sar-tui-rescue*")) == []


def test_a_rescue_file_that_cannot_be_written_to_either_is_removed_and_the_one_before_stays(
    data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorded = Safe(data)
    recorded.to_trial(2)
    delete(data)
    recorded.to_trial(3)
    (before,) = rescue_files(data)

    def refuse(_: sqlite3.Connection) -> None:
        raise StoreError("The disk is full.", temporary=True)

    recorded.until(lambda: len(recorded.all(TRIAL)) == 4)
    monkeypatch.setattr("sar_tui.store.recorder.transaction", refuse)
    recorded.recorder.run(lambda: True)
    assert rescue_files(data) == [before]
    assert str(before) in recorded.safeguard.text
    assert recorded.recorder.pending > 0


# --- bringing it back


def rescued(data: Path, happens: Callable[[Path], None] = delete) -> Safe:
    """A session that ended in a rescue file."""
    recorded = Safe(data)
    recorded.to_trial(2)
    happens(data)
    recorded.to_trial(6)
    while recorded.step():
        pass
    recorded.recorder.run(lambda: True)
    recorded.reader.close()
    return recorded


@pytest.mark.parametrize("happens", [delete, replace, delete_the_log])
def test_a_session_in_a_rescue_file_is_brought_back_once(
    data: Path, happens: Callable[[Path], None]
) -> None:
    recorded = rescued(data, happens)
    (path,) = rescue_files(data)
    (brought,) = bring_back(data)
    assert (brought.file, brought.session, brought.participants, brought.task, brought.problem) == (
        path, recorded.id, "P01", "keyboard", "",
    )  # fmt: skip
    with closing(connect(data)) as database:
        assert list(sessions.history(database, recorded.id)) == recorded.records
        assert len(sessions.rows(database, "trials", recorded.id)) == 6
        assert sessions.stored_status(database, recorded.id) == "completed"
    assert rescue_files(data) == []
    assert len(list(data.glob("sar-tui-rescued-*.db"))) == 1
    assert bring_back(data) == []


def test_what_a_locked_database_lacked_is_brought_back(data: Path, locked: Safe) -> None:
    locked.recorder.run(lambda: True)
    locked.reader.execute("ROLLBACK")
    assert [brought.session for brought in bring_back(data)] == [locked.id]
    with closing(connect(data)) as database:
        assert list(sessions.history(database, locked.id)) == locked.records
        assert [flaw for flaw in flaws(database) if flaw.kind in ("log", "rows")] == []


def test_files_that_were_brought_back_are_all_kept(data: Path) -> None:
    recorded = rescued(data)
    (path,) = rescue_files(data)
    for _ in range(3):
        bring_back(data)
        shutil.copy(data / f"sar-tui-rescued-{recorded.id}.db", path)
    assert len(list(data.glob("sar-tui-rescued-*.db"))) == 3


def test_a_session_that_went_on_differently_since_is_not_overwritten(
    data: Path, locked: Safe
) -> None:
    locked.recorder.run(lambda: True)
    locked.reader.execute("ROLLBACK")
    with closing(connect(data)) as database:
        sessions.begin_run(database, locked.id, software={}, machine={})
        before = sessions.rows(database, "trials", locked.id)
        (brought,) = bring_back(data)
        assert "went on differently" in brought.problem
        assert sessions.rows(database, "trials", locked.id) == before
    assert rescue_files(data) == [brought.file]


def test_participants_and_programmes_that_the_database_lacks_are_brought_back(data: Path) -> None:
    with closing(connect(data)) as database:
        participants.add(database, "P09")
        programmes.save(
            database,
            "P09",
            "keyboard",
            Programme({"attempts": 3}),
            after=0,
            author="Ana",
            reason="Tired",
        )
    rescued(data)
    bring_back(data)
    with closing(connect(data)) as database:
        assert participants.codes(database) == ["P09"]
        (programme,) = programmes.versions(database, "P09", "keyboard")
        assert (programme.parameters, programme.author, programme.reason) == (
            {"attempts": 3},
            "Ana",
            "Tired",
        )


def test_a_transaction_in_a_database_that_stays_is_not_refused(data: Path) -> None:
    database = connect(data)
    for code in ("P01", "P02"):
        with transaction(database) as connection:
            connection.execute(
                "INSERT INTO participants (code, created_at) VALUES (?, 'now')", (code,)
            )
        with closing(connect(data)) as other:
            other.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    assert participants.codes(database) == ["P01", "P02"]

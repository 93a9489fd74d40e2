"""A session whose database is removed, replaced or locked goes on in a rescue file, which can be
brought back.
"""

import os
import shutil
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
)
from sar_tui.store.integrity import flaws
from sar_tui.store.programmes import Programme
from sar_tui.store.rescue import bring_back, rescue_files
from sar_tui.store.safeguard import Safeguard
from tests.store.by_hand import sql
from tests.store.test_recorder import Recorded


def refuse(*_: object) -> Any:
    raise StoreError("The disk is full.", temporary=True)


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

    def __init__(self, data: Path, trials: int = 0, **parameters: Any) -> None:
        super().__init__(data, inline=False, attempts=2, prompts_per_attempt=3, **parameters)
        self.data = data
        self.safeguard = self.recorder.safeguard = Safeguard(data, self.id, self.database)
        self.session.begin()
        self.to_trial(trials)

    def to_trial(self, number: int) -> None:
        """Continue until this many trials are acknowledged."""
        while len(self.all(STORED)) < number:
            if self.all(WAITING)[-1].what == "storage":
                self.write_and_hear()
            else:
                assert self.step()

    def end(self) -> None:
        """Play to the end, and end the recorder's thread."""
        self.finish()
        self.recorder.run(lambda: True)
        self.reader.close()

    @property
    def rescue_file(self) -> Path:
        (path,) = rescue_files(self.data)
        return path

    def assert_rescued(self, trials: int | None = None, saved: int = 0) -> None:
        """The rescue file holds all that was not saved before."""
        with closing(open_file(self.rescue_file)) as rescue:
            assert list(sessions.history(rescue, self.id)) == self.records[saved:]
            assert trials is None or len(sessions.rows(rescue, "trials", self.id)) == trials

    def assert_back(self, trials: int | None = None) -> None:
        """The database holds all, and no rescue file has more."""
        with closing(connect(self.data)) as database:
            assert list(sessions.history(database, self.id)) == self.records
            assert [flaw for flaw in flaws(database) if flaw.kind in ("log", "rows")] == []
            if trials:
                assert len(sessions.rows(database, "trials", self.id)) == trials
                assert sessions.stored_status(database, self.id) == "completed"


@pytest.mark.parametrize("happens", [delete, replace, move_away, delete_the_log, empty])
def test_a_session_whose_database_is_gone_goes_on_in_a_rescue_file_with_all_that_was_in_it(
    data: Path, happens: Callable[[Path], None]
) -> None:
    participants.add(connect(data), "P09")
    recorded = Safe(data, 2)
    happens(data)
    before = os.umask(0)
    try:
        recorded.to_trial(4)
    finally:
        os.umask(before)
    recorded.recorder.write()
    recorded.assert_rescued(trials=4)
    assert stat.S_IMODE(recorded.rescue_file.stat().st_mode) == 0o600
    if happens is not empty:  # its pages can be read by nobody
        assert participants.codes(open_file(recorded.rescue_file)) == ["P09"]
    if happens is delete:  # a rescue file that is removed too is followed by another
        for path in data.glob(f"{recorded.rescue_file.name}*"):
            path.unlink()
        recorded.to_trial(5)
        recorded.recorder.write()
        recorded.assert_rescued()


def test_the_experimenter_is_told_and_the_trial_is_repeated(data: Path) -> None:
    recorded = Safe(data, 1)
    recorded.until(lambda: recorded.all(WAITING)[-1].what == "response")
    delete(data)
    recorded.write_and_hear()
    (changed,) = recorded.all(STORAGE)
    assert changed.working
    assert f"{data / FILE} was removed while it was in use" in changed.reason
    assert str(recorded.rescue_file) in changed.reason
    waiting = recorded.all(WAITING)[-1]
    assert (waiting.stage, waiting.reason, waiting.detail) == ("paused", "restored", changed.reason)


def test_a_database_that_is_damaged_is_left_and_what_could_not_be_read_is_said(data: Path) -> None:
    recorded = Safe(data, 2)
    saved = len(recorded.history)
    for name in (FILE, f"{FILE}-wal"):
        with (data / name).open("r+b") as file:
            file.write(b"\xff" * (data / name).stat().st_size)
    sql(recorded.database, "PRAGMA shrink_memory")
    recorded.to_trial(4)
    recorded.recorder.write()
    said = recorded.safeguard.text
    assert "is damaged." in said or "is not a SQLite database." in said
    assert said.endswith(" What was done before that is not in it.")
    recorded.assert_rescued(trials=2, saved=saved)


def test_what_followed_is_added_to_the_database(
    data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As when a disk is taken away during a session, and comes back."""
    recorded = Safe(data, 2)
    away = data.with_name("away")
    data.rename(away)

    def unreadable(*_: object) -> StoreConnection:
        target = open_file(data / f"sar-tui-rescue-{recorded.id}.db")
        recorded.safeguard._rescue._copy_facts(target)
        return target

    monkeypatch.setattr(recorded.safeguard._rescue, "copy_all", unreadable)
    recorded.to_trial(6)
    recorded.end()
    recorded.rescue_file.rename(away / recorded.rescue_file.name)
    shutil.rmtree(data)
    away.rename(data)
    (brought,) = bring_back(data)
    assert brought.problem == ""
    recorded.assert_back(trials=6)


def test_a_file_system_whose_file_numbers_change_does_not_fill_up(
    data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def changed(_: StoreConnection) -> None:
        raise Moved("It was replaced.")

    recorded = Safe(data, 1)
    monkeypatch.setattr(StoreConnection, "check", changed)
    for _ in range(20):
        with suppress(Moved):
            recorded.recorder.write()
    assert len(rescue_files(data)) == 5


def test_a_trial_is_not_acknowledged_while_it_can_be_written_nowhere(
    data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorded = Safe(data, 1)
    delete(data)
    with monkeypatch.context() as patched:
        patched.setattr(recorded.safeguard._rescue, "copy_all", refuse)
        recorded.until(lambda: len(recorded.all(TRIAL)) == 2)
        recorded.write_and_hear()
        assert recorded.all(STORAGE)[-1].reason == "The disk is full."
        assert len(recorded.all(STORED)) == 1
        assert recorded.recorder.pending > 0
    recorded.write_and_hear()
    assert len(recorded.all(STORED)) == 2
    recorded.recorder.write()
    recorded.assert_rescued(trials=2)


@pytest.fixture
def locked(data: Path) -> Safe:
    """A session whose database another program keeps locked, with messages that were not
    written.
    """
    recorded = Safe(data, 2)
    sql(recorded.database, "PRAGMA busy_timeout=0")
    sql(recorded.reader, "BEGIN IMMEDIATE")
    recorded.until(lambda: len(recorded.all(TRIAL)) == 3)
    return recorded


def test_a_short_lock_is_waited_for_and_what_a_long_one_refuses_is_in_a_rescue_file(
    data: Path, locked: Safe
) -> None:
    locked.write_and_hear()
    assert locked.all(STORAGE) == []
    for _ in range(10):
        locked.write_on_a_thread()
    locked.clock.advance(0)
    assert [changed.working for changed in locked.all(STORAGE)] == [False]
    locked.recorder.run(lambda: True)
    assert locked.recorder.pending == 0
    assert "keeps sar-tui.db locked" in locked.safeguard.text
    locked.assert_rescued(trials=3)
    sql(locked.reader, "ROLLBACK")
    assert [brought.session for brought in bring_back(data)] == [locked.id]
    locked.assert_back()


def test_without_room_for_a_rescue_file_none_is_left(
    data: Path, locked: Safe, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sar_tui.store.rescue.copy_session", refuse)
    locked.recorder.run(lambda: True)
    assert (locked.recorder.pending > 0, locked.safeguard.text) == (True, "")
    assert list(data.glob("sar-tui-rescue*")) == []


def test_a_rescue_file_that_cannot_be_written_to_either_is_removed_and_the_one_before_stays(
    data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorded = Safe(data, 2)
    delete(data)
    recorded.to_trial(3)
    before = recorded.rescue_file
    recorded.until(lambda: len(recorded.all(TRIAL)) == 4)
    monkeypatch.setattr("sar_tui.store.recorder.transaction", refuse)
    recorded.recorder.run(lambda: True)
    assert recorded.rescue_file == before
    assert str(before) in recorded.safeguard.text
    assert recorded.recorder.pending > 0


def rescued(data: Path, happens: Callable[[Path], None] = delete) -> Safe:
    """A session that ended in a rescue file."""
    recorded = Safe(data, 2)
    happens(data)
    recorded.to_trial(6)
    recorded.end()
    return recorded


@pytest.mark.parametrize("happens", [delete, replace, delete_the_log])
def test_a_rescued_session_is_brought_back_once_with_participants_and_programmes(
    data: Path, happens: Callable[[Path], None]
) -> None:
    with closing(connect(data)) as database:
        participants.add(database, "P09")
        own = Programme({"attempts": 3})
        programmes.save(database, "P09", "keyboard", own, after=0, author="Ana", reason="Tired")
        saved = programmes.versions(database, "P09", "keyboard")
    recorded = rescued(data, happens)
    path = recorded.rescue_file
    (brought,) = bring_back(data)
    assert (brought.file, brought.session, brought.participants, brought.task, brought.problem) == (
        path, recorded.id, "P01", "keyboard", "",
    )  # fmt: skip
    recorded.assert_back(trials=6)
    with closing(connect(data)) as database:
        assert participants.codes(database) == ["P09"]
        assert programmes.versions(database, "P09", "keyboard") == saved != []
    assert rescue_files(data) == bring_back(data) == []
    for number in range(1, 4):
        assert len(list(data.glob("sar-tui-rescued-*.db"))) == number, "all are kept"
        shutil.copy(data / f"sar-tui-rescued-{recorded.id}.db", path)
        bring_back(data)


def test_a_session_that_went_on_differently_is_not_overwritten(data: Path, locked: Safe) -> None:
    locked.recorder.run(lambda: True)
    sql(locked.reader, "ROLLBACK")
    with closing(connect(data)) as database:
        sessions.begin_run(database, locked.id, software={}, machine={})
        before = sessions.rows(database, "trials", locked.id)
        (brought,) = bring_back(data)
        assert "went on differently" in brought.problem
        assert sessions.rows(database, "trials", locked.id) == before
    assert rescue_files(data) == [brought.file]


def test_a_transaction_in_a_database_that_stays_is_not_refused(data: Path) -> None:
    database = connect(data)
    for code in ("P01", "P02"):
        participants.add(database, code)
        sql(data, "PRAGMA wal_checkpoint(TRUNCATE)")
    assert participants.codes(database) == ["P01", "P02"]
    delete(data)
    with pytest.raises(Moved, match="was removed while it was in use"):
        participants.add(database, "P03")

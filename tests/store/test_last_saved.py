"""Data that was saved and is no longer in the database after a crash is reported."""

import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.store.database import FILE, SAVED, connect
from sar_tui.store.locks import hold
from sar_tui.store.safeguard import forget, losses
from sar_tui.store.troubles import troubles
from tests.store.test_rescue import Safe

WAL_HEADER, FRAME = 32, 24 + 4096


def after_a_crash(recorded: Safe, copy: Path) -> Path:
    """Return a copy of the data folder as it is when the program is killed now."""
    shutil.copytree(recorded.data, copy)
    return copy


@pytest.fixture
def crashed(data: Path, tmp_path: Path) -> Path:
    """The data folder after a crash in the fourth trial."""
    recorded = Safe(data)
    recorded.to_trial(4)
    return after_a_crash(recorded, tmp_path / "crashed")


def flip_the_last_byte(log: Path) -> None:
    frames = bytearray(log.read_bytes())
    frames[-1] ^= 1
    log.write_bytes(frames)


def flip_a_byte_of_the_header(log: Path) -> None:
    frames = bytearray(log.read_bytes())
    frames[17] ^= 1
    log.write_bytes(frames)


def flip_a_byte_in_the_middle(log: Path) -> None:
    frames = bytearray(log.read_bytes())
    frames[WAL_HEADER + (len(frames) // FRAME // 2) * FRAME + 99] ^= 1
    log.write_bytes(frames)


def cut_short(log: Path) -> None:
    with log.open("r+b") as file:
        file.truncate(log.stat().st_size - 5)


@pytest.mark.parametrize(
    "damage",
    [
        flip_the_last_byte,
        flip_a_byte_of_the_header,
        flip_a_byte_in_the_middle,
        cut_short,
        Path.unlink,
    ],
)
def test_a_damaged_or_deleted_log_is_reported(
    crashed: Path, damage: Callable[[Path], None]
) -> None:
    damage(crashed / f"{FILE}-wal")
    with closing(connect(crashed)) as database:
        (loss,) = losses(database, crashed)
        assert (loss.saved.attempt, loss.saved.trial) == (2, 1)
        assert loss.kept is None or loss.kept.seq < loss.saved.seq
        (text,) = troubles(database, crashed)
        assert text.startswith(
            f"Data was lost: session {loss.session} was saved up to attempt 2, trial 1, but "
        )
        assert losses(database, crashed) == [loss], "it is told until somebody accepts it"


def test_a_whole_log_is_no_loss_and_its_note_is_not_kept(crashed: Path) -> None:
    assert len(list((crashed / SAVED).iterdir())) == 1
    with closing(connect(crashed)) as database:
        assert losses(database, crashed) == []
    assert list((crashed / SAVED).iterdir()) == []


def test_a_database_that_was_deleted_after_a_crash_is_reported(crashed: Path) -> None:
    for path in crashed.glob(f"{FILE}*"):
        path.unlink()
    with closing(connect(crashed)) as database:
        (loss,) = losses(database, crashed)
        assert "is missing altogether" in str(loss)


def test_a_session_under_way_is_no_loss(crashed: Path) -> None:
    (crashed / f"{FILE}-wal").unlink()
    (note,) = (crashed / SAVED).iterdir()
    with closing(connect(crashed)) as database:
        lock = hold(crashed, "session", note.stem)
        assert losses(database, crashed) == []
        lock.release()
        assert len(losses(database, crashed)) == 1


@pytest.mark.parametrize("content", [b"", b"{", b'{"seq": "x"}', b"\xff" * 128])
def test_a_note_that_cannot_be_read_is_no_loss(crashed: Path, content: bytes) -> None:
    (note,) = (crashed / SAVED).iterdir()
    note.write_bytes(content)
    (crashed / f"{FILE}-wal").unlink()
    with closing(connect(crashed)) as database:
        assert losses(database, crashed) == []


def test_a_session_in_the_database_file_needs_no_note(data: Path) -> None:
    recorded = Safe(data)
    recorded.to_trial(1)
    (note,) = (data / SAVED).iterdir()
    forget(recorded.reader, data, recorded.id)
    assert not note.exists()
    with closing(sqlite3.connect(f"file:{data / FILE}?immutable=1", uri=True)) as without_log:
        assert without_log.execute("SELECT count(*) FROM trials").fetchone() == (1,)


def test_a_session_in_a_rescue_file_is_no_loss(data: Path) -> None:
    recorded = Safe(data)
    recorded.to_trial(1)
    for path in data.glob(f"{FILE}*"):
        path.unlink()
    recorded.to_trial(2)
    with closing(connect(data)) as database:
        assert losses(database, data) == []
        (text,) = troubles(database, data)
    assert "holds data that is not in the database. `sar-tui rescue` brings it back." in text

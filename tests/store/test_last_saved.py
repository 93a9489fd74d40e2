"""Data that was saved and is no longer in the database after a crash is reported."""

import os
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


def flip(log: Path, place: int | None) -> None:
    """Change a byte of a log; None: one in the middle."""
    frames = bytearray(log.read_bytes())
    middle = WAL_HEADER + (len(frames) // FRAME // 2) * FRAME + 99
    frames[middle if place is None else place] ^= 1
    log.write_bytes(frames)


DAMAGE: dict[str, Callable[[Path], object]] = {
    "its last byte is another": lambda log: flip(log, -1),
    "a byte of its header is another": lambda log: flip(log, 17),
    "a byte in its middle is another": lambda log: flip(log, None),
    "it is cut short": lambda log: os.truncate(log, log.stat().st_size - 5),
    "it is deleted": Path.unlink,
}


WAL_HEADER, FRAME = 32, 24 + 4096


@pytest.fixture
def crashed(data: Path, tmp_path: Path) -> Path:
    """A copy of the data folder as it is when the program is killed in the fourth trial."""
    recorded = Safe(data, 4)
    return Path(shutil.copytree(recorded.data, tmp_path / "crashed"))


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_or_deleted_log_is_told(crashed: Path, damage: str) -> None:
    DAMAGE[damage](crashed / f"{FILE}-wal")
    with closing(connect(crashed)) as database:
        (loss,) = losses(database, crashed)
        assert (loss.saved.attempt, loss.saved.trial) == (2, 1)
        assert loss.kept is None or loss.kept.seq < loss.saved.seq
        (text,) = troubles(database, crashed)
        assert text.startswith(
            f"Data was lost: session {loss.session} was saved up to attempt 2, trial 1"
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
    recorded = Safe(data, 1)
    (note,) = (data / SAVED).iterdir()
    forget(recorded.reader, data, recorded.id)
    assert not note.exists()
    with closing(sqlite3.connect(f"file:{data / FILE}?immutable=1", uri=True)) as without_log:
        assert without_log.execute("SELECT count(*) FROM trials").fetchone() == (1,)


def test_a_session_in_a_rescue_file_is_no_loss(data: Path) -> None:
    recorded = Safe(data, 1)
    for path in data.glob(f"{FILE}*"):
        path.unlink()
    recorded.to_trial(2)
    with closing(connect(data)) as database:
        assert losses(database, data) == []
        (text,) = troubles(database, data)
    assert "holds data that is not in the database. `sar-tui rescue` brings it back." in text

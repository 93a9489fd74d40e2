"""Damage to the database is found, wherever it is; data that is whole is found to be whole."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from sqlite3 import Connection

import pytest

from sar_tui.store.backup import back_up
from sar_tui.store.database import FILE, StoreError, connect
from sar_tui.store.integrity import flaws
from tests.played import simulated
from tests.store.by_hand import sql, value


@pytest.fixture
def recorded(data: Path) -> Iterator[Connection]:
    """A database with a session of each task."""
    simulated(data, attempts=2, prompts_per_attempt=3)
    simulated(data, "pairs", "P01", "P02", attempts=2, prompts_per_attempt=3)
    simulated(data, "reaching", attempts=2)
    with closing(connect(data)) as database:
        yield database


def test_recorded_sessions_and_a_new_database_are_whole(
    recorded: Connection, tmp_path: Path
) -> None:
    assert found(recorded) == []
    with closing(connect(tmp_path / "new")) as database:
        assert found(database) == []


DAMAGE = {
    "DELETE FROM messages WHERE seq=7": ("gap", "events, 1 are missing."),
    "DELETE FROM messages WHERE seq=1": ("gap", "events, 1 are missing."),
    "DELETE FROM trials WHERE attempt=2 AND trial=1": ("gap", "trials of attempt 2, 1 are missing."),
    "DELETE FROM attempts WHERE attempt=1": ("gap", "attempts, 1 are missing."),
    "DELETE FROM attempts WHERE attempt=1 AND seat='B'": ("gap", "trials of seat B, but not its result."),
    "DELETE FROM trials WHERE attempt=2 AND seat='B'": ("gap", "the result of seat B, but no trial."),
    "DELETE FROM sessions WHERE task='keyboard'": ("orphan", "There are trials without a session."),
    "DELETE FROM seats": ("orphan", "There are sessions without a seat."),
    "DELETE FROM session_numbers": ("orphan", "There are events without a number of their session."),
    "DELETE FROM topics WHERE id=5": ("orphan", "There are events without a topic."),
    "DELETE FROM imu_streams": ("orphan", "There are samples without their stream."),
    "UPDATE sessions SET mode='live'": ("orphan", "There are seats without a participant."),
    "INSERT INTO records (id, version, kind, participant, seat, at, content, recorded_at)"
    " VALUES ('e', 1, 'pain', 'P99', 'A', '', '{}', '')": ("orphan", "There are records without a participant."),
    "UPDATE imu_chunks SET data=zeroblob(length(data)) WHERE seq=1": ("samples", "stream 1 is damaged."),
    "UPDATE imu_chunks SET n=n+1 WHERE seq=1": ("samples", "stream 1 is damaged."),
    "UPDATE imu_streams SET layout='[[]]'": ("samples", "The layout of sensor stream 1 cannot be read."),
    "UPDATE trials SET timing='{' WHERE trial=1": ("text", "of the texts trials.timing cannot be read."),
    "UPDATE trials SET stimulus=CAST(x'ff' AS TEXT) WHERE trial=1": ("text", "rows of trials have characters that"),
    "UPDATE sessions SET id=CAST(x'ff' AS TEXT) WHERE task='pairs'": ("text", "rows of sessions have characters"),
    "UPDATE messages SET message=substr(message, 2) WHERE seq=3": ("text", "texts messages.message cannot be"),
}  # fmt: skip


def found(database: Connection) -> list[tuple[str, str]]:
    return [(flaw.kind, flaw.what) for flaw in flaws(database)]


@pytest.mark.parametrize("damage", DAMAGE)
def test_damage_is_found(recorded: Connection, damage: str) -> None:
    sql(recorded, damage)
    kind, words = DAMAGE[damage]
    assert any(each == kind and words in what for each, what in found(recorded)), found(recorded)
    assert all(flaw.where for flaw in flaws(recorded)), "each names its session or participant"


def test_damaged_pages_are_found_and_nothing_else_is_and_they_are_not_backed_up(
    recorded: Connection, data: Path, tmp_path: Path
) -> None:
    sql(recorded, "PRAGMA wal_checkpoint(TRUNCATE)")
    root = value(recorded, "SELECT rootpage FROM sqlite_master WHERE name='trials'")
    size = value(recorded, "PRAGMA page_size")
    recorded.close()
    with (data / FILE).open("rb+") as file:
        file.seek((root - 1) * size)
        file.write(b"\xff" * 100)
    with closing(connect(data)) as database:
        assert {flaw.kind for flaw in flaws(database)} == {"file"}
    with pytest.raises(StoreError, match="damaged"):
        back_up(data, tmp_path / "safe")
    assert list((tmp_path / "safe").iterdir()) == []

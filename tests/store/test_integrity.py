"""Damage to the database is found, wherever it is; data that is whole is found to be whole."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store.database import FILE, connect
from sar_tui.store.integrity import Flaw, flaws


@pytest.fixture
def recorded(data: Path, catalogue: Catalogue) -> Iterator[sqlite3.Connection]:
    """A database with a session of each task."""
    few = {
        "keyboard": {"prompts_per_attempt": 3},
        "pairs": {"prompts_per_attempt": 3},
        "reaching": {},
    }
    for task, settings in few.items():
        codes = ["P01", "P02"][: 2 if task == "pairs" else 1]
        plan = make_plan(
            catalogue, task, codes, {"attempts": 2, **settings}, seed=3, mode="simulated"
        )
        simulate(plan, PEOPLE["average"], data, catalogue)
    with closing(connect(data)) as database:
        yield database


def found(database: sqlite3.Connection) -> list[tuple[str, str]]:
    return [(flaw.kind, flaw.what) for flaw in flaws(database)]


def test_recorded_sessions_are_whole(recorded: sqlite3.Connection) -> None:
    assert found(recorded) == []


def test_a_new_database_is_whole(data: Path) -> None:
    with closing(connect(data)) as database:
        assert found(database) == []


@pytest.mark.parametrize(
    ("damage", "flaw"),
    [
        ("DELETE FROM messages WHERE seq=7", ("gap", "events, 1 are missing.")),
        ("DELETE FROM messages WHERE seq=1", ("gap", "events, 1 are missing.")),
        (
            "DELETE FROM trials WHERE attempt=2 AND trial=1",
            ("gap", "trials of attempt 2, 1 are missing."),
        ),
        ("DELETE FROM attempts WHERE attempt=1", ("gap", "attempts, 1 are missing.")),
        (
            "DELETE FROM sessions WHERE task='keyboard'",
            ("orphan", "There are trials without a session."),
        ),
        ("DELETE FROM seats", ("orphan", "There are sessions without a seat.")),
        (
            "DELETE FROM session_numbers",
            ("orphan", "There are events without a number of their session."),
        ),
        ("DELETE FROM topics WHERE id=5", ("orphan", "There are events without a topic.")),
        ("DELETE FROM imu_streams", ("orphan", "There are samples without their stream.")),
        ("UPDATE sessions SET mode='live'", ("orphan", "There are seats without a participant.")),
        (
            "UPDATE imu_chunks SET data=zeroblob(length(data)) WHERE seq=1",
            ("samples", "stream 1 is damaged."),
        ),
        ("UPDATE imu_chunks SET n=n+1 WHERE seq=1", ("samples", "stream 1 is damaged.")),
        (
            "UPDATE trials SET timing='{' WHERE trial=1",
            ("text", "of the texts trials.timing cannot be read."),
        ),
        (
            "UPDATE imu_streams SET layout='[[]]'",
            ("samples", "The layout of sensor stream 1 cannot be read."),
        ),
        (
            "UPDATE trials SET stimulus=CAST(x'ff' AS TEXT) WHERE trial=1",
            ("text", "rows of trials have characters that"),
        ),
        (
            "UPDATE sessions SET id=CAST(x'ff' AS TEXT) WHERE task='pairs'",
            ("text", "rows of sessions have characters"),
        ),
        (
            "DELETE FROM attempts WHERE attempt=1 AND seat='B'",
            ("gap", "trials of seat B, but not its result."),
        ),
        (
            "DELETE FROM trials WHERE attempt=2 AND seat='B'",
            ("gap", "the result of seat B, but no trial."),
        ),
        (
            "INSERT INTO records (id, version, kind, participant, seat, at, content, recorded_at)"
            " VALUES ('e', 1, 'pain', 'P99', 'A', '', '{}', '')",
            ("orphan", "There are records without a participant."),
        ),
        (
            "UPDATE messages SET message=substr(message, 2) WHERE seq=3",
            ("text", "texts messages.message cannot be"),
        ),
    ],
)
def test_damage_is_found(recorded: sqlite3.Connection, damage: str, flaw: tuple[str, str]) -> None:
    recorded.execute(damage)
    kind, words = flaw
    assert any(each == kind and words in what for each, what in found(recorded)), found(recorded)


def test_damaged_pages_are_found_and_nothing_else_is_looked_for(
    recorded: sqlite3.Connection, data: Path
) -> None:
    recorded.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    (root,) = recorded.execute("SELECT rootpage FROM sqlite_master WHERE name='trials'").fetchone()
    (size,) = recorded.execute("PRAGMA page_size").fetchone()
    recorded.close()
    with (data / FILE).open("rb+") as file:
        file.seek((root - 1) * size)
        file.write(b"\xff" * 100)
    with closing(connect(data)) as database:
        assert {flaw.kind for flaw in flaws(database)} == {"file"}


def test_the_last_attempt_of_an_interrupted_session_lacks_its_result(
    recorded: sqlite3.Connection,
) -> None:
    recorded.execute(
        "DELETE FROM attempts WHERE attempt=2 AND session=(SELECT id FROM sessions WHERE "
        "task='pairs')"
    )
    assert [kind for kind, _ in found(recorded)] == ["rows"], "deleted by hand, and no gap"


def test_a_flaw_names_its_session(recorded: sqlite3.Connection) -> None:
    (session,) = recorded.execute("SELECT id FROM sessions WHERE task='reaching'").fetchone()
    recorded.execute("UPDATE imu_chunks SET crc32=crc32+1 WHERE seq=2")
    damaged, of_log = flaws(recorded)
    assert damaged == Flaw("samples", session, "Block 2 of sensor stream 1 is damaged.")
    assert (of_log.kind, of_log.where) == ("log", session)

"""A session is resumed by a replay of its log: nothing else that is stored has a part in it, and
none of it is run.
"""

import shutil
import sqlite3
import zlib
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node
from sar_tui.loop.session import Session
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.replay.replay import replay
from sar_tui.runs.plan import Plan, make_plan
from sar_tui.runs.run import Run, resume, start
from sar_tui.simulation.operator import PROFILES, SimulatedOperator
from sar_tui.simulation.participant import SimulatedParticipant, SimulatedPartner
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import connect
from tests.program import Call

CATALOGUE = Catalogue()
SHORT: dict[str, Any] = {"attempts": 12, "prompts_per_attempt": 3}
PLANS: dict[str, tuple[str, list[str], dict[str, Any]]] = {
    "keyboard": ("keyboard", ["P01"], SHORT | {"practice_attempts": 1, "encouragement": True}),
    "on request": ("keyboard", ["P01"], SHORT | {"feedback_schedule": "request", "language": "es"}),
    "summaries": (
        "keyboard",
        ["P01"],
        SHORT | {"feedback_schedule": "summary", "feedback_every": 2},
    ),
    "operated": (
        "keyboard",
        ["P01"],
        SHORT | {"operator_feedback": "approve", "operator_difficulty": "approve"},
    ),
    "pairs": ("pairs", ["P01", "P02"], {"attempts": 4}),
    "long": ("keyboard", ["P01"], {"attempts": 24, "prompts_per_attempt": 20}),
}


def a_plan(name: str) -> Plan:
    task, codes, parameters = PLANS[name]
    return make_plan(CATALOGUE, CATALOGUE.task(task), codes, parameters, seed=4)


def nodes(name: str) -> Callable[[Any, Any, int], list[Node]]:
    def make(task: Any, theme: Any, seed: int) -> list[Node]:
        partners = [
            SimulatedPartner(PEOPLE["average"], task, seed, seat=seat) for seat in task.seats[1:]
        ]
        operators = [SimulatedOperator(PROFILES["careful"], seed)] if name == "operated" else []
        return [SimulatedParticipant(PEOPLE["average"], task, seed), *partners, *operators]

    return make


def play(run: Run, clock: VirtualClock, steps: int | None = None) -> None:
    """Do a number of steps of a run, or all of them, and close it."""
    run.begin()
    while not run.session.ended and (steps is None or steps > 0):
        assert clock.step()
        steps = None if steps is None else steps - 1
    assert run.session.faults == []
    run.recorder.write()
    run.close()


def interrupted(data: Path, name: str = "keyboard", steps: int = 100) -> str:
    """Play a session for some steps, and return its id."""
    run = start(a_plan(name), data, CATALOGUE, clock := VirtualClock(), nodes(name))
    play(run, clock, steps)
    assert not run.session.ended
    return run.id


def go_on(
    data: Path, session: str, name: str = "keyboard", run: int = 2, steps: int | None = None
) -> None:
    clock = VirtualClock(run * 1000 * SECOND)
    play(resume(session, data, CATALOGUE, clock, nodes(name)), clock, steps)


@pytest.mark.parametrize("name", PLANS)
def test_a_session_that_was_resumed_twice_follows_from_its_inputs(name: str, data: Path) -> None:
    session = interrupted(data, name, 80)
    go_on(data, session, name, 2, 30)
    go_on(data, session, name, 3)
    with closing(connect(data)) as database:
        row = sessions.find(database, data, session)
        assert row["status"] == "completed"
        assert replay(database, data, CATALOGUE, row).identical


def test_the_progress_of_a_resume_is_told(data: Path) -> None:
    session = interrupted(data, "long", 400)
    told: list[tuple[int, int]] = []
    run = resume(
        session,
        data,
        CATALOGUE,
        VirtualClock(1000 * SECOND),
        nodes("long"),
        lambda *now: told.append(now),
    )
    run.close()
    (of,) = {of for _, of in told}
    assert of == int(run.session.bus._seq) - 1
    assert [done for done, _ in told] == sorted(done for done, _ in told)
    assert 0 < told[0][0] < told[-1][0] <= of
    assert len(told) > 10


# --- state that an earlier version stored

_A_FOLDER = b"cposix\nmkdir\n(Vharm\ntR."
_A_CLASS = b"csar_tui.loop.session\nSession\n(N}Vharm\nI01\nstb."
"""Pickles: one makes a folder, one changes a class of the program."""


@pytest.mark.parametrize("harmful", [_A_FOLDER, _A_CLASS])
@pytest.mark.parametrize("is_migrated", [True, False])
def test_a_pickle_in_a_database_from_elsewhere_is_never_loaded(
    harmful: bytes, is_migrated: bool, call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Given a table of checkpoints as version 19 had it, of an earlier database or added to a
    present one.
    """
    data, other = tmp_path / "data", tmp_path / "other"
    monkeypatch.chdir(tmp_path)
    session = interrupted(other, "long", 1400)
    plant(other / "sar-tui.db", session, harmful, is_migrated=is_migrated)
    interrupted(data)
    assert call("site", "BERN").code == 0
    backup = tmp_path / "copy.db"
    shutil.copyfile(other / "sar-tui.db", other / f"sar-tui-rescue-{session}.db")
    for arguments in (("rescue",), ("check",), ("backup", "--verify", "--to", backup)):
        assert call(*arguments, "--data", other).code == 0
    assert call("merge", backup, "--site", "BASEL").code == 0
    go_on(other, session, "long")
    assert not (tmp_path / "harm").exists()
    assert not hasattr(Session, "harm")


def plant(path: Path, session: str, harmful: bytes, *, is_migrated: bool) -> None:
    packed = zlib.compress(harmful)
    with closing(sqlite3.connect(path)) as database, database:
        database.execute(
            "CREATE TABLE IF NOT EXISTS checkpoints (session TEXT PRIMARY KEY, seq INTEGER NOT "
            "NULL,"
            " program TEXT NOT NULL, crc32 INTEGER NOT NULL, state BLOB NOT NULL)"
        )
        if not database.execute(
            "UPDATE checkpoints SET state=?, crc32=?", (packed, zlib.crc32(packed))
        ).rowcount:
            database.execute(
                "INSERT INTO checkpoints VALUES (?, 1, 'any', ?, ?)",
                (session, zlib.crc32(packed), packed),
            )
        if is_migrated:
            database.execute("DELETE FROM _sqlite_migrations WHERE name='version_20'")
            database.execute("PRAGMA user_version=19")


def test_a_migration_removes_the_pickles_of_earlier_versions(data: Path) -> None:
    session = interrupted(data)
    plant(data / "sar-tui.db", session, _A_FOLDER, is_migrated=True)
    with closing(connect(data)) as database:
        assert not database.execute(
            "SELECT 1 FROM sqlite_master WHERE name='checkpoints'"
        ).fetchall()

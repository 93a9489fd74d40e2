"""A session is resumed from its last checkpoint exactly as from a replay of it all."""

import os
import pickle
import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.framework.checkpoint import CheckpointError, restore
from sar_tui.framework.clock import SECOND, VirtualClock
from sar_tui.framework.node import Node
from sar_tui.framework.session import Session
from sar_tui.framework.session_phase import Phase
from sar_tui.plugins import Catalogue
from sar_tui.runs import checkpoints
from sar_tui.runs.plan import Plan, make_plan
from sar_tui.runs.run import Run, resume, start
from sar_tui.runs.sensors import simulated_nodes
from sar_tui.simulation.operator import PROFILES, SimulatedOperator
from sar_tui.simulation.participant import SimulatedParticipant, SimulatedPartner
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from tests.examples import first

CATALOGUE = Catalogue()
SHORT = {"attempts": 12, "prompts_per_attempt": 3}
PLANS = {
    "keyboard": ("keyboard", ["P01"], SHORT | {"practice_attempts": 1, "encouragement": True}),
    "on request": ("keyboard", ["P01"], SHORT | {"feedback_schedule": "request", "language": "es"}),
    "summaries": ("keyboard", ["P01"], SHORT | {"feedback_schedule": "summary", "feedback_every": 2}),
    "operated": ("keyboard", ["P01"], SHORT | {"operator_feedback": "approve", "operator_difficulty": "approve"}),
    "pairs": ("pairs", ["P01", "P02"], {"attempts": 4}),
}


@pytest.fixture(autouse=True)
def after_each_attempt(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make a checkpoint after each attempt."""
    monkeypatch.setattr(checkpoints, "EVERY", 1)


def a_plan(name: str) -> Plan:
    task, codes, parameters = PLANS[name]
    return make_plan(CATALOGUE, CATALOGUE.task(task), codes, parameters, seed=4)


def nodes(name: str) -> Callable[[Any, Any, int], list[Node]]:
    def make(task: Any, theme: Any, seed: int) -> list[Node]:
        partners = [SimulatedPartner(PEOPLE["average"], task, seed, seat=seat) for seat in task.seats[1:]]
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


def change(data: Path, statement: str, *values: object) -> None:
    with closing(sqlite3.connect(data / "sar-tui.db")) as database, database:
        assert database.execute(statement, values).rowcount == 1


def events(data: Path, session: str) -> list[tuple[Any, ...]]:
    with closing(sqlite3.connect(data / "sar-tui.db")) as database:
        query = "SELECT seq, run, at_ns, topic, message FROM events WHERE session=? ORDER BY seq"
        return database.execute(query, (session,)).fetchall()


@pytest.fixture
def replayed_from(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The numbers of the messages after which replays began."""
    began: list[int] = []
    history = sessions.history

    def watched(database: sqlite3.Connection, session: str, after: int = 0) -> Any:
        began.append(after)
        return history(database, session, after)

    monkeypatch.setattr(sessions, "history", watched)
    return began


@pytest.mark.parametrize("steps", [80, *first(0, (95, 110, 121, 130))])
@pytest.mark.parametrize("name", PLANS)
def test_the_rest_of_a_session_is_the_same_with_and_without_a_checkpoint(
    name: str, steps: int, data: Path, tmp_path: Path, replayed_from: list[int]
) -> None:
    session = interrupted(data, name, steps)
    replayed = tmp_path / "replayed"
    shutil.copytree(data, replayed)
    change(replayed, "DELETE FROM checkpoints")
    for folder in (data, replayed):
        clock = VirtualClock(1000 * SECOND)
        play(resume(session, folder, CATALOGUE, clock, nodes(name)), clock)
    assert events(data, session) == events(replayed, session)
    assert replayed_from[0] > 0
    assert replayed_from[1:] == [0]


def test_a_session_is_resumed_again_from_a_checkpoint_of_its_second_run(data: Path, replayed_from: list[int]) -> None:
    session = interrupted(data, steps=60)
    for number, steps in ((2, 40), (3, None)):
        clock = VirtualClock(number * 1000 * SECOND)
        play(resume(session, data, CATALOGUE, clock, nodes("keyboard")), clock, steps)
    assert 0 < replayed_from[0] < replayed_from[1]
    with closing(sqlite3.connect(data / "sar-tui.db")) as database:
        assert database.execute("SELECT status FROM sessions").fetchall() == [("completed",)]


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE checkpoints SET program='another'",
        "UPDATE checkpoints SET crc32=crc32+1",
        "UPDATE sessions SET parameters=json_set(parameters, '$.speech', 'file:words')",
    ],
)
def test_a_checkpoint_of_another_program_or_a_damaged_one_is_not_used(
    statement: str, data: Path, replayed_from: list[int]
) -> None:
    session = interrupted(data)
    change(data, statement)
    play(resume(session, data, CATALOGUE, clock := VirtualClock(1000 * SECOND), nodes("keyboard")), clock)
    assert replayed_from == [0]


def test_a_checkpoint_that_cannot_be_read_is_left_out(
    data: Path, replayed_from: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(session: Session, data: bytes) -> None:
        restore(session, b"no pickle")

    session = interrupted(data)
    monkeypatch.setattr("sar_tui.runs.run.restore", refuse)
    play(resume(session, data, CATALOGUE, clock := VirtualClock(1000 * SECOND), nodes("keyboard")), clock)
    assert replayed_from == [0]


def test_a_checkpoint_is_made_by_each_python(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Before 3.11.4, Python pickled a member of an Enum as a call of getattr."""

    def reduce(member: Phase, protocol: object) -> tuple[object, ...]:
        return getattr, (Phase, member.name)

    monkeypatch.setattr(Phase, "__reduce_ex__", reduce)
    interrupted(data)
    change(data, "DELETE FROM checkpoints")


class _Harmful:
    def __reduce__(self) -> Any:
        return os.mkdir, ("harm",)


def test_a_checkpoint_runs_no_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    plan = a_plan("keyboard")
    session = Session(plan.task(plan.parameters), CATALOGUE.theme("calm"), VirtualClock(), 1)
    with pytest.raises(CheckpointError, match="is not plain data"):
        restore(session, pickle.dumps(_Harmful()))
    assert list(tmp_path.iterdir()) == []


def test_a_session_with_a_sensor_is_replayed_as_a_whole(data: Path, replayed_from: list[int]) -> None:
    """Its samples are no plain data."""
    plan = make_plan(CATALOGUE, CATALOGUE.task("reaching"), ["P01"], {"attempts": 2}, seed=4)
    clock = VirtualClock()

    def make(task: Any, theme: Any, seed: int) -> list[Node]:
        return [*simulated_nodes(PEOPLE["average"], task, seed, clock, PEOPLE["average"])]

    run = start(plan, data, CATALOGUE, clock, make)
    ended: list[object] = []
    run.session.bus.tap(
        lambda cascade: ended.extend(one for one in cascade if one.topic.name.endswith("attempt_ended"))
    )
    run.begin()
    while not ended:
        assert clock.step()
    run.recorder.write()
    run.close()
    with closing(sqlite3.connect(data / "sar-tui.db")) as database:
        assert database.execute("SELECT * FROM checkpoints").fetchall() == []

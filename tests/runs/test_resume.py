"""A session is resumed by a replay of its log: nothing else that is stored has a part in it, and
none of it is run.
"""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node
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

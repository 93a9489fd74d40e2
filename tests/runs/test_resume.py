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
from sar_tui.loop.topics import STEP_ENDED, WAITING
from sar_tui.model.step import Entry
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
from tests.facts import each
from tests.played import play

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
    "questions": (
        "keyboard",
        ["P01"],
        {"attempts": 1, "prompts_per_attempt": 1, "questions": "exertion remark enjoyment"},
    ),
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


def interrupted(data: Path, name: str = "keyboard", steps: int = 100) -> str:
    """Play a session for some steps, and return its id."""
    run = start(a_plan(name), data, CATALOGUE, clock := VirtualClock(), nodes(name))
    play(run, clock, steps)
    assert not run.session.ended
    return run.id


def go_on(
    data: Path, session: str, name: str = "keyboard", run: int = 2, steps: int | None = None
) -> Run:
    again = resume(
        session, data, CATALOGUE, clock := VirtualClock(run * 1000 * SECOND), nodes(name)
    )
    play(again, clock, steps)
    assert again.session.faults == []
    return again


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in PLANS if name != "questions"])
def test_a_session_that_was_resumed_twice_follows_from_its_inputs(name: str, data: Path) -> None:
    session = interrupted(data, name, 80)
    go_on(data, session, name, 2, 30)
    assert go_on(data, session, name, 3).number == 3
    with closing(connect(data)) as database:
        row = sessions.find(database, data, session)
        assert row["status"] == "completed"
        assert [one["run"] for one in sessions.rows(database, "runs", session)] == [1, 2, 3]
        runs = [trial["run"] for trial in sessions.rows(database, "trials", session)]
        assert runs == sorted(runs)
        assert replay(database, data, CATALOGUE, row).identical


@pytest.mark.parametrize("name", ["exertion", "remark", "enjoyment"])
def test_a_question_that_was_half_answered_is_answered_after_the_resume(
    data: Path, name: str
) -> None:
    run = start(a_plan("questions"), data, CATALOGUE, clock := VirtualClock(), nodes("questions"))
    run.begin()
    while chosen(run) != name:
        assert clock.step()
    run.recorder.write()
    run.close()
    go_on(data, run.id, "questions")
    with closing(connect(data)) as database:
        history = sessions.history(database, run.id)
        ended = [one.message for one in history if one.topic is STEP_ENDED]
    asked = ["exertion", "remark", "enjoyment"]
    assert each(ended, "name status") == [(question, "answered") for question in asked]


def chosen(run: Run) -> str:
    """The question that stands with something chosen or typed; empty if there is none."""
    waiting = run.session.bus.last(WAITING)
    asked = waiting.step if waiting else None
    return asked.step.name if asked and asked.entry != Entry() else ""


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

"""A session that was interrupted while a question stood is finished by a simulated participant,
whatever was chosen.
"""

from pathlib import Path

import pytest

from sar_tui.loop.bus import FAULT
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.topics import STEP_ENDED, WAITING
from sar_tui.model.messages import Fault, StepEnded
from sar_tui.model.step import Entry
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import Run, resume, start
from sar_tui.simulation.participant import SimulatedParticipant
from sar_tui.simulation.participant_model import PEOPLE

CATALOGUE = Catalogue()
SETTINGS = {"attempts": 1, "prompts_per_attempt": 1, "questions": "effort remark enjoyment"}


def nodes(task, theme, seed):  # type: ignore[no-untyped-def]
    return [SimulatedParticipant(PEOPLE["average"], task, seed)]


def chosen(run: Run) -> str:
    """The step that stands with something chosen or typed; empty if there is none."""
    waiting = run.session.bus.last(WAITING)
    asked = waiting.step if waiting else None
    return asked.step.name if asked and asked.entry != Entry() else ""


@pytest.mark.parametrize("name", ["effort", "remark", "enjoyment"])
def test_the_question_is_answered_after_the_resume(data: Path, name: str) -> None:
    plan = make_plan(CATALOGUE, CATALOGUE.task("keyboard"), ["P01"], SETTINGS, seed=4)
    run = start(plan, data, CATALOGUE, clock := VirtualClock(), nodes)
    run.begin()
    while chosen(run) != name:
        assert clock.step()
    run.recorder.write()
    run.close()
    run = resume(run.id, data, CATALOGUE, clock := VirtualClock(1000 * SECOND), nodes)
    answered: list[StepEnded] = []
    faults: list[Fault] = []
    run.session.bus.subscribe(STEP_ENDED, answered.append)
    run.session.bus.subscribe(FAULT, faults.append)
    run.begin()
    while not run.session.ended:
        assert clock.step(), "the session waits for ever"
    run.recorder.write()
    run.close()
    assert (answered[0].name, answered[0].status, faults) == (name, "answered", [])

"""A session that the computer went down in, and that was resumed: its second run has an earlier
steady clock.
"""

from pathlib import Path
from typing import Any

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.topics import NOTE_ADDED
from sar_tui.model.messages import NoteAdded
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import Run, resume, start
from sar_tui.simulation.participant import SimulatedParticipant
from sar_tui.simulation.participant_model import PEOPLE


def interrupted(data: Path, steps: int = 25) -> str:
    """Play some steps of a session of two attempts, and leave it; return its id."""
    clock = VirtualClock(9000 * SECOND)
    plan = make_plan(
        Catalogue(), "keyboard", ["P01"], {"attempts": 2, "prompts_per_attempt": 3}, seed=4
    )
    run = start(plan, data, Catalogue(), clock, _participants)
    _play(run, clock, steps)
    return run.id


def resumed(data: Path) -> str:
    """Play a session of two runs; return its id."""
    clock = VirtualClock(5 * SECOND)
    run = resume(interrupted(data), data, Catalogue(), clock, _participants)
    _play(run, clock)
    return run.id


def _participants(task: Any, theme: Any, seed: int) -> list[SimulatedParticipant]:
    return [SimulatedParticipant(PEOPLE["average"], task, seed)]


def _play(run: Run, clock: VirtualClock, steps: int | None = None) -> None:
    run.begin()
    run.session.bus.post(NOTE_ADDED, NoteAdded(text=f"in run {run.number}", at=clock.now()))
    while not run.session.ended and (steps is None or steps > 0):
        assert clock.step()
        steps = None if steps is None else steps - 1
    run.recorder.write()
    run.close()

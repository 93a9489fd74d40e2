"""A session that the computer went down in, and that was resumed: its second run has an earlier
steady clock.
"""

from pathlib import Path

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.topics import NOTE_ADDED
from sar_tui.model.messages import NoteAdded
from sar_tui.model.units import SECOND
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import Run, resume, start
from tests.played import catalogue, play, somebody


def interrupted(data: Path, steps: int = 25) -> str:
    """Play some steps of a session of two attempts, and leave it; return its id."""
    settings = {"attempts": 2, "prompts_per_attempt": 3}
    plan = make_plan(catalogue(), "keyboard", ["P01"], settings, seed=4)
    clock = VirtualClock(9000 * SECOND)
    return noted(start(plan, data, catalogue(), clock, somebody), clock, steps)


def resumed(data: Path) -> str:
    """Play a session of two runs; return its id."""
    clock = VirtualClock(5 * SECOND)
    run = resume(interrupted(data), data, catalogue(), clock, somebody)
    return noted(run, clock)


def noted(run: Run, clock: VirtualClock, steps: int | None = None) -> str:
    note = NoteAdded(text=f"in run {run.number}", at=clock.now())
    run.session.bus.post(NOTE_ADDED, note)
    return play(run, clock, steps)

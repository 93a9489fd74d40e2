"""Sessions for tests of what is stored: simulated at once, or live and played step by step."""

from functools import cache
from pathlib import Path
from typing import Any

from sar_tui.loop.clock import VirtualClock
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import Run
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.operator import PROFILES
from sar_tui.simulation.participant import SimulatedParticipant
from sar_tui.simulation.participant_model import PEOPLE

catalogue = cache(Catalogue)


def simulated(
    data: Path, task: str = "keyboard", *codes: str, user: str = "average", seed: int = 3,
    operator: str = "", **settings: Any,
) -> str:  # fmt: skip
    """Simulate a session, of P01 unless another is named, and return its id."""
    plan = make_plan(catalogue(), task, codes or ["P01"], settings, seed=seed, mode="simulated")
    return simulate(plan, PEOPLE[user], data, catalogue(), operator=PROFILES.get(operator))


def somebody(task: Any, theme: Any, seed: int) -> list[SimulatedParticipant]:
    """Return the nodes that press the keys of a live session."""
    return [SimulatedParticipant(PEOPLE["average"], task, seed)]


def play(run: Run, clock: VirtualClock, steps: int | None = None) -> str:
    """Play a live session to its end, or some steps of it, and leave it; return its id."""
    run.begin()
    while not run.session.ended and (steps is None or steps > 0):
        assert clock.step()
        steps = None if steps is None else steps - 1
    run.recorder.write()
    run.close()
    return run.id

"""Makes the golden sessions of the present rules: ``python -m tests.replay.make_golden``.

Two simulated keyboard sessions, one of them with an operator, one of reaching, one of pairs with an
operator, and a live keyboard session that was interrupted and resumed.
"""

import gzip
import sqlite3
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from sar_tui.loop.clock import VirtualClock
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.rules.version import RULES
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import resume, start
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.operator import PROFILES
from sar_tui.simulation.participant import SimulatedParticipant
from sar_tui.simulation.participant_model import PEOPLE

GOLDEN = Path(__file__).parent / "golden"
FEW = {"prompts_per_attempt": 4}


def make(folder: Path) -> None:
    """Play the sessions into a data folder."""
    operated = {**FEW, "operator_feedback": "approve"}
    _simulate(folder, "keyboard", ("P01",), "average", {"attempts": 4, **FEW})
    _simulate(
        folder,
        "keyboard",
        ("P02",),
        "poor",
        {"attempts": 3, "threshold": 700, **operated},
        operator="careful",
    )
    _simulate(folder, "reaching", ("P01",), "competent", {"attempts": 1, "reaches_per_attempt": 2})
    _simulate(
        folder, "pairs", ("P01", "P02"), "average", {"attempts": 2, **operated}, operator="careful"
    )
    _play_interrupted(folder)


def _simulate(
    folder: Path,
    task: str,
    codes: Sequence[str],
    user: str,
    settings: Mapping[str, object],
    operator: str = "",
) -> None:
    plan = make_plan(Catalogue(), task, codes, settings, seed=5, mode="simulated")
    simulate(plan, PEOPLE[user], folder, Catalogue(), operator=PROFILES.get(operator))


def _play_interrupted(folder: Path) -> None:
    def participants(task: Any, theme: Any, seed: int) -> list[SimulatedParticipant]:
        return [SimulatedParticipant(PEOPLE["average"], task, seed)]

    clock = VirtualClock()
    plan = make_plan(Catalogue(), "keyboard", ["P01"], {"attempts": 3, **FEW}, seed=4)
    run = start(plan, folder, Catalogue(), clock, participants)
    for steps in (20, 10**6):
        run.begin()
        for _ in range(steps):
            if run.session.ended or not clock.step():
                break
        run.recorder.write()
        run.close()
        if steps == 20:
            clock = VirtualClock(1000 * SECOND)
            run = resume(run.id, folder, Catalogue(), clock, participants)


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        make(folder)
        with closing(sqlite3.connect(folder / "sar-tui.db")) as database:
            database.execute("VACUUM INTO ?", (str(folder / "packed.db"),))
        packed = gzip.compress((folder / "packed.db").read_bytes(), mtime=0)
    (GOLDEN / f"rules-{RULES}.db.gz").write_bytes(packed)


if __name__ == "__main__":
    main()

"""A program that is killed again and again. It loads once, and plays each part in a child process
of its own.

Each line on its standard input names a part and its arguments. It answers with the child's process
id; the child says what it has done.
"""

import os
import sys
from pathlib import Path

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.topics import STORED, WAITING
from sar_tui.model.messages import Stored
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.runs import run as run_module
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import resume, start
from sar_tui.simulation.participant import SimulatedParticipant
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store.database import connect
from sar_tui.store.rescue import bring_back

CATALOGUE = Catalogue()
SETTINGS = {"attempts": 40, "prompts_per_attempt": 10}


def say(*words: object) -> None:
    """Write a line at once, in one system call."""
    os.write(1, (" ".join(map(str, words)) + "\n").encode())


def play(data: Path, seed: str, session: str = "") -> None:
    """Play a session as fast as it can be stored, and say which trials were acknowledged."""
    run_module.VirtualClock = type("NoClock", (), {})  # type: ignore[misc]  # it is recorded as a live session is
    clock = VirtualClock(SECOND)
    nodes = lambda task, theme, seed: [SimulatedParticipant(PEOPLE["average"], task, seed)]  # noqa: E731
    if session:
        run = resume(session, data, CATALOGUE, clock, nodes)
    else:
        plan = make_plan(CATALOGUE, CATALOGUE.task("keyboard"), ["P01"], SETTINGS, seed=int(seed))
        run = start(plan, data, CATALOGUE, clock, nodes)
    bus, waits = run.session.bus, [""]

    def stored(trial: Stored) -> None:
        say(trial.attempt, trial.trial)

    bus.subscribe(STORED, stored)
    bus.subscribe(WAITING, lambda waiting: waits.append(waiting.what))
    run.begin()
    while not run.session.ended:
        if waits[-1] == "storage":
            run.recorder.write()
            clock.advance(0)
        else:
            clock.step()
    run.recorder.write()
    run.close()


def main() -> None:
    """Play the parts that are asked for."""
    for line in sys.stdin:
        part, folder, *arguments = line.split()
        if (child := os.fork()) == 0:
            {"play": play, "connect": connect, "bring_back": bring_back}[part](
                Path(folder), *arguments
            )
            say("end")
            os._exit(0)
        say(child)
        os.waitpid(child, 0)
        say("gone")


if __name__ == "__main__":
    main()

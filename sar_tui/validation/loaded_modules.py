"""Lists the modules that a task's session loads: ``python -m sar_tui.validation.loaded_modules TASK
[FOLDER…]``.

It loads what a live session loads, except the app; then a simulated participant does two attempts,
to find modules that are loaded later. Modules of the simulation itself are left out. Prints JSON.
"""

import sys
from pathlib import Path

LONGEST_S = 3600
"""Simulated time after which the session counts as endless."""


def main(name: str, folders: list[str]) -> None:
    """Print ``{"modules": {name: file}, "package": name, "folder": path}``; package and folder are
    the task's.
    """
    from sar_tui.inputs.keyboard import Keyboard
    from sar_tui.loop.clock import VirtualClock
    from sar_tui.loop.node import Node
    from sar_tui.loop.session import Session
    from sar_tui.loop.topics import STORED, TRIAL
    from sar_tui.model.messages import Stored, TrialEnded
    from sar_tui.model.units import SECOND
    from sar_tui.plugins import Catalogue, task_folder
    from sar_tui.rules.parameters import build

    catalogue = Catalogue(tuple(map(Path, folders)))
    kind = catalogue.task(name)
    task = kind(build(kind.Parameters, {"attempts": 2}))
    clock = VirtualClock()
    Keyboard()
    if kind.sensor_seats(task.parameters):
        from sar_tui.inputs.imu_feed import ImuFeed
        from sar_tui.inputs.sensor import Imu
        from sar_tui.inputs.sources import open_source

        Imu(ImuFeed(open_source(getattr(task.parameters, "imu", "phidget")), clock.now))
    live = set(sys.modules)

    from sar_tui.simulation.participant import SimulatedParticipant
    from sar_tui.simulation.participant_model import PEOPLE

    participant: list[Node] = [SimulatedParticipant(PEOPLE["average"], task, 0)]
    if kind.sensor_seats(task.parameters):
        hand = open_source("simulated", clock=clock)
        move = getattr(hand, "move", None)
        participant = [
            SimulatedParticipant(PEOPLE["average"], task, 0, move),
            Imu(ImuFeed(hand, clock.now)),
        ]
    simulation = set(sys.modules) - live

    session = Session(task, catalogue.theme("calm"), clock, 0, participant)

    def store(trial: TrialEnded) -> None:
        session.bus.post(STORED, Stored(seat=trial.seat, attempt=trial.attempt, trial=trial.trial))

    session.bus.subscribe(TRIAL, store)
    session.begin()
    while (
        not (session.ended or session.broken) and clock.now() < LONGEST_S * SECOND and clock.step()
    ):
        pass
    if session.broken:
        sys.exit(f"its session failed ({session.broken.error}, {session.broken.place})")
    if not session.ended:
        sys.exit("its session does not end")

    import msgspec

    files = {
        module: str(file)
        for module in sorted(set(sys.modules) - simulation)
        if (file := getattr(sys.modules[module], "__file__", None))
    }
    package = kind.__module__.rpartition(".")[0] or kind.__module__
    print(
        msgspec.json.encode(
            {"modules": files, "package": package, "folder": str(task_folder(kind))}
        ).decode()
    )


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])

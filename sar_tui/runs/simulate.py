"""Run a whole session with a simulated participant on the virtual clock."""

from collections.abc import Callable
from pathlib import Path

from sar_tui.framework.clock import VirtualClock
from sar_tui.framework.node import Node
from sar_tui.framework.task import Task
from sar_tui.framework.theme import Theme
from sar_tui.framework.topics import ATTEMPT_ENDED
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import Plan
from sar_tui.runs.run import speaking, start
from sar_tui.simulation.operator import OperatorProfile, SimulatedOperator
from sar_tui.simulation.participant import SimulatedParticipant, SimulatedPartner
from sar_tui.simulation.person import Person


def simulate(
    plan: Plan,
    person: Person,
    folder: Path,
    catalogue: Catalogue,
    progress: Callable[[int], None] = lambda attempt: None,
    operator: OperatorProfile | None = None,
    partner: Person | None = None,
) -> str:
    """Run a whole session with a simulated participant, on a virtual clock, into the database; returns its id.

    A task for two has a ``partner`` at seat B: as the participant is, if no other is named. An ``operator`` decides on
    what the agent proposes, in the modes that the plan's parameters set.

    Raises:
        StoreError, PluginError: as ``start``.
        Failed: the task raised.
    """
    clock = VirtualClock()

    def sit_down(task: Task, theme: Theme) -> list[Node]:
        beside = [*([SimulatedOperator(operator, plan.seed)] if operator else []), *speaking(task, theme)]
        if not task.sensed(task.parameters):
            others = [SimulatedPartner(partner or person, task, plan.seed, seat) for seat in task.seats[1:]]
            return [SimulatedParticipant(person, task, plan.seed), *others, *beside]
        from sar_tui.runs.sensors import simulated  # loads numpy

        return [*simulated(person, task, plan.seed, clock, partner or person), *beside]

    run = start(plan, folder, catalogue, clock, sit_down)
    try:
        run.session.bus.subscribe(ATTEMPT_ENDED, lambda ended: progress(ended.attempt))
        run.begin()
        session = run.session
        while (not session.ended or session.is_agent_acting) and not session.broken and clock.step():
            pass
        session.detach()
        session.bus.drain()
        run.recorder.write()
        run.check()
    finally:
        run.close()
    return run.id

"""Run a whole session with a simulated participant on the virtual clock."""

from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path

from sar_tui.loop.clock import PacedClock, VirtualClock
from sar_tui.loop.node import Node
from sar_tui.loop.session import Parts, Session
from sar_tui.loop.task import Task
from sar_tui.loop.topics import ATTEMPT_ENDED
from sar_tui.model.messages import AttemptEnded, Fault
from sar_tui.model.theme import Theme
from sar_tui.outputs.node import OutputNode
from sar_tui.outputs.output import Output
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import Failed, Plan
from sar_tui.runs.run import output_nodes, start
from sar_tui.simulation.operator import OperatorProfile, SimulatedOperator
from sar_tui.simulation.participant import SimulatedParticipant, SimulatedPartner
from sar_tui.simulation.participant_model import Person


def simulate(
    plan: Plan,
    person: Person,
    folder: Path,
    catalogue: Catalogue,
    progress: Callable[[int], None] = lambda attempt: None,
    operator: OperatorProfile | None = None,
    partner: Person | None = None,
    bodies: Sequence[Output] = (),
    parts: Parts | None = None,
    began: datetime | None = None,
    leave_after: int = 0,
) -> str:
    """Run a whole session into the database, and return its id.

    It takes no longer than computing it, unless an output works on a thread of its own, which is
    waited for.

    Args:
        plan: the session.
        person: the simulated participant.
        folder: the data folder.
        catalogue: where the theme is found.
        progress: called with each attempt's number when it has ended.
        operator: decides on the agent's proposals, in the modes that the plan's parameters set.
        partner: at seat B of a task for two; by default, like ``person``.
        bodies: outputs besides those that the plan names; they report at once.
        parts: the classes of the framework's nodes, if not its own.
        began: as for ``start``.
        leave_after: leave it after so many attempts, practice included, as a program does that is
            closed: it can be resumed. 0: go on to its end.

    Raises:
        StoreError, PluginError, ParameterError: as ``start``.
        Failed: the task raised, there or in its simulated participant, or waits for ever.
    """
    clock = VirtualClock() if set(plan.parameters.outputs) <= {"screen"} else PacedClock()

    def make_nodes(task: Task, theme: Theme, seed: int) -> list[Node]:
        others = [
            *([SimulatedOperator(operator, seed)] if operator else []),
            *output_nodes(task, theme),
        ]
        others += [OutputNode(body, body.name, theme) for body in bodies]
        return [*people(person, task, seed, clock, partner), *others]

    run = start(plan, folder, catalogue, clock, make_nodes, parts, began)
    left = False

    def attempt_ended(ended: AttemptEnded) -> None:
        nonlocal left
        progress(ended.attempt)
        left = ended.attempt == leave_after

    try:
        run.session.bus.subscribe(ATTEMPT_ENDED, attempt_ended)
        run.begin()
        session = run.session
        play(session, clock, lambda: left)
        session.detach()
        session.bus.drain()
        run.check()
        if fault := participant_fault(session):
            raise Failed(
                f"The simulated participant failed ({fault.error}, {fault.place}). Look at the "
                "method rehearse of the "
                f"task {plan.task.name}. What was done so far is kept."
            )
        if not session.ended and not left:
            raise Failed(
                f"The session {run.id} stopped before its end: the task {plan.task.name} waits "
                "for something that the "
                "simulated participant does not do. What was done so far is kept."
            )
    finally:
        try:
            run.recorder.write()
        finally:
            run.close()
    return run.id


def people(
    person: Person, task: Task, seed: int, clock: VirtualClock, partner: Person | None = None
) -> list[Node]:
    """Return the nodes of the simulated participants of a task, with their sensors."""
    if task.sensor_seats(task.parameters):
        from sar_tui.runs.sensors import simulated_nodes  # imports numpy

        return simulated_nodes(person, task, seed, clock, partner or person)
    partners = [
        SimulatedPartner(partner or person, task, seed, seat=seat) for seat in task.seats[1:]
    ]
    return [SimulatedParticipant(person, task, seed), *partners]


def play(
    session: Session, clock: VirtualClock, is_left: Callable[[], bool] = lambda: False
) -> None:
    """Let the time of a session pass until it has ended or failed or is left, or nothing is
    awaited.
    """
    while not is_left() and goes_on(session) and clock.step():
        pass


def participant_fault(session: Session) -> Fault | None:
    """Return the first fault of a simulated participant; None if there is none."""
    people = (SimulatedParticipant.name, SimulatedPartner.name)
    return next((fault for fault in session.faults if fault.node in people), None)


def goes_on(session: Session) -> bool:
    """Return True until the session has ended, and its goodbye was decided on and said, or a part
    of it failed.
    """
    is_whole = session.broken is None and participant_fault(session) is None
    return is_whole and (not session.ended or session.is_agent_acting or session.awaits_operator)

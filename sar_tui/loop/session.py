"""A session: the nodes, inputs and outputs on one bus."""

from collections.abc import Generator, Iterable, Sequence
from contextlib import closing
from typing import NamedTuple

from sar_tui.loop.attempts import NextAttempt
from sar_tui.loop.bus import FAULT, Bus, Record
from sar_tui.loop.clock import Clock, VirtualClock
from sar_tui.loop.marks import TrialMark
from sar_tui.loop.node import Node
from sar_tui.loop.nodes import VITAL
from sar_tui.loop.nodes.action_center import ActionCenter
from sar_tui.loop.nodes.arbiter import Arbiter
from sar_tui.loop.nodes.event_handler import EventHandler
from sar_tui.loop.nodes.memory import Memory
from sar_tui.loop.nodes.perception import Perception
from sar_tui.loop.nodes.protocol import OperatorProtocol
from sar_tui.loop.replay_comparison import Comparison
from sar_tui.loop.task import Task
from sar_tui.loop.topics import ACTING, SESSION, SESSION_ENDED, THEME
from sar_tui.loop.undo import Done
from sar_tui.model.messages import AgentActing, Fault, SessionStarted, ThemeApplied
from sar_tui.model.step import Step
from sar_tui.model.theme import Theme

RULES = 1
"""Version of the rules by which a session is played: it rises whenever the same inputs lead to other
messages than before. A session is replayed and resumed only by the rules that it was recorded with.
"""


class ReplayError(ValueError):
    """A replay differs from the record: another version of the task, the theme or the program made
    it.
    """


class Session:
    """The nodes of the loop on one bus.

    Args:
        task: built with its parameters.
        theme: how the agent looks and speaks.
        clock: live or virtual.
        seed: decides everything random.
        extra: input and output nodes: a screen, a simulated participant.
        best: the participant's best results of earlier sessions, by level.
        others_best: the same for the other participants, by seat.
        names: what the agent calls each participant, by seat; without a name, the seat.
        done_today: what the participant did today, if something limits a day
            (`rules.limits.Dose`).
        steps: those between attempts beside the task's own.
        parts: the classes of the framework's nodes, if not its own.

    Attributes:
        parameters: with which the task was built; a therapist may change some for
            ``task.parameters``.
    """

    def __init__(
        self,
        task: Task,
        theme: Theme,
        clock: Clock,
        seed: int,
        extra: Sequence[Node] = (),
        best: dict[str, float] | None = None,
        others_best: dict[str, dict[str, float]] | None = None,
        names: dict[str, str] | None = None,
        done_today: dict[str, float] | None = None,
        steps: tuple[Step, ...] = (),
        parts: "Parts | None" = None,
    ) -> None:
        self.task = task
        self.parameters = task.parameters
        self.theme = theme
        self.seed = seed
        self.best = best or {}
        self.others_best = others_best or {}
        self.names = names or {}
        self.done_today = done_today or {}
        self.steps = steps
        self.clock = clock
        self.bus = Bus(clock)
        self.faults: list[Fault] = []
        self.ended = False
        self.is_agent_acting = False
        self.awaits_operator = False
        self._tr = task.tr
        self._use_texts(theme)
        self.bus.subscribe(THEME, lambda applied: self._use_texts(applied.theme))
        self.core = core_nodes(task, theme, seed, parts or OWN_PARTS)
        for node in self.core:
            node.attach(self.bus)
        self.nodes = (*self.core, *extra)
        event_handler = next(node for node in self.core if isinstance(node, EventHandler))
        self._event_handler = event_handler
        self._script, self._status = event_handler.session, event_handler.status
        self._extra = extra
        self.bus.subscribe(SESSION_ENDED, lambda _: self._end())
        self.bus.subscribe(ACTING, self._agent_acted)
        self.bus.subscribe(FAULT, self.faults.append)

    @property
    def next_attempt(self) -> NextAttempt:
        """Level and settings of the next attempt, which a therapist may change."""
        return self._script.attempts.next

    @property
    def is_resting(self) -> bool:
        """True in a rest that must be taken, also while the session is paused."""
        return self._status.is_resting

    @property
    def can_skip_attempt(self) -> bool:
        """True if there is an attempt that a participant may leave out, also while the session is
        paused.
        """
        return self._status.can_skip_attempt

    @property
    def awaits_agreement(self) -> bool:
        """True until all required answers are given; also if one was refused."""
        return self._script.steps.awaits_agreement

    @property
    def broken(self) -> Fault | None:
        """The fault that stopped this session, if there was one."""
        return (
            next((fault for fault in self.faults if fault.node in self._event_handler.vital), None)
            if self.faults
            else None
        )

    @property
    def trial_mark(self) -> TrialMark:
        """The trial that a mark is put on now, and the mark that is on it."""
        return self._event_handler.trial_mark

    def undoable(self, *actors: str) -> Done | None:
        """Return the last act that one of these people can take back now; None if there is none."""
        now = self.clock.now()
        found = [done for who in actors if (done := self._event_handler.undoable(who, now))]
        return max(found, key=lambda done: done.at, default=None)

    @property
    def takes_backspace(self) -> bool:
        """True while Backspace may be a response, or deletes a letter of an answer in words."""
        asked = self._script.steps.asked
        is_typing = asked is not None and asked.step.kind == "text"
        return self._event_handler.open_trial is not None or is_typing

    @property
    def pictures_to_come(self) -> tuple[str, ...]:
        """Pictures of the prompt that comes next, so that they can be prepared."""
        trial = self._event_handler.open_trial
        return trial.pictures if trial else ()

    @property
    def is_recording_over(self) -> bool:
        """True if a recording that replaces a sensor is at its end, so that the session cannot go
        on in this run.
        """
        return self._status.blockers.is_recording_over

    def begin(self, run: int = 1) -> None:
        """Begin a run: attach the inputs and outputs, and start the loop."""
        for node in self._extra:
            node.attach(self.bus)
        self.apply_theme(self.theme)
        started = SessionStarted(
            run=run,
            task=self.task.name,
            theme=self.theme.name,
            seed=self.seed,
            best=self.best,
            others_best=self.others_best,
            names=self.names,
            rules=RULES,
            done_today=self.done_today,
            steps=self.steps if run == 1 else (),
        )
        self.bus.publish(SESSION, started)

    def apply_theme(self, theme: Theme) -> None:
        """Use another theme from here on."""
        self.theme = theme
        self.bus.publish(THEME, ThemeApplied(theme=theme))

    def replay(self, history: Iterable[Record]) -> None:
        """Bring the nodes to the state at the end of a record. Call it before ``begin``.

        Raises:
            ReplayError: the derived messages differ from the record.
        """
        compared = self.compare(history)
        if difference := compared.difference:
            if not (difference.recorded and difference.derived):
                raise ReplayError("The record of this session is incomplete: it cannot be resumed.")
            raise ReplayError(
                f"Message {difference.seq} ({difference.topic}) differs from the record: "
                "the task, the theme or the program has changed since."
            )
        if fault := self.broken:
            raise ReplayError(f"The task failed in this session: {fault.error}, {fault.place}.")

    def compare(self, history: Iterable[Record]) -> Comparison:
        """Derive the messages of a record anew, up to the first one that differs. Call it before
        ``begin``.

        Wording does not count, nor do faults of inputs and outputs, which are not attached yet, nor
        what was added to the record later.
        """
        compared = Comparison()
        with closing(self.derive(history)) as derived:
            for record, cascade in derived:
                is_of_loop = not record.topic.stream and record.topic.origin != "later"
                if is_of_loop and not self._is_fault_of_extra(record):
                    compared.expect(record)
                compared.derive(cascade)
                if compared.difference:
                    break
        compared.finish()
        return compared

    def derive(
        self, history: Iterable[Record]
    ) -> Generator[tuple[Record, list[Record]], None, None]:
        """Yield each message of a record, with all messages that the nodes derive now if it is an
        input.

        The recorded inputs are published in order, each at its recorded time. Then the session's
        own clock is used again, and the numbers of messages continue those of the record.
        """
        clock = VirtualClock()
        self.bus.clock = clock
        derived: list[Record] = []

        def listen(cascade: list[Record]) -> None:
            derived.extend(record for record in cascade if not record.topic.stream)

        self.bus.tap(listen)
        last = 0
        try:
            for record in history:
                if record.topic.origin == "input":
                    clock.set(record.at)
                    self.bus.publish(record.topic, record.message)
                if not record.topic.stream:
                    last = record.seq
                yield record, derived[:]
                derived.clear()
        finally:
            self.bus.untap(listen)
            self.bus.clock = self.clock
            if last:
                self.bus.count_from(last + 1)

    def _is_fault_of_extra(self, record: Record) -> bool:
        return isinstance(record.message, Fault) and record.message.node not in {
            node.name for node in self.core
        }

    def detach(self) -> None:
        """Release devices. May be called again."""
        for node in self.nodes:
            node.detach()

    def _end(self) -> None:
        """Note the end. Nothing is detached yet, because the outputs still say goodbye."""
        self.ended = True

    def _use_texts(self, theme: Theme) -> None:
        """Give the task the theme's own wordings of texts; in a replay, those of the recorded
        theme.
        """
        self.task.tr = self._tr.including(theme.texts)

    def _agent_acted(self, agent: AgentActing) -> None:
        self.is_agent_acting = agent.acting
        self.awaits_operator = agent.awaits_operator


class Parts(NamedTuple):
    """Classes of the framework's nodes that validations replace with broken ones, to see their
    tests fail.
    """

    perception: type[Perception] = Perception
    memory: type[Memory] = Memory
    event_handler: type[EventHandler] = EventHandler


OWN_PARTS = Parts()


def problem_of_nodes(nodes: Sequence[object]) -> str:
    """Return why these cannot be a task's own nodes, as the end of a sentence; empty if they can.

    Timers tell nodes by their names.
    """
    taken = {kind.name for kind in (*OWN_PARTS, ActionCenter, Arbiter, OperatorProtocol)}
    for node in nodes:
        if not isinstance(node, Node):
            return f"among its nodes is {node!r:.60}, which is no Node."
        name = getattr(node, "name", None)
        if not isinstance(name, str) or not name:
            return f"its node {type(node).__name__} has no name."
        if name in taken:
            return f"its node {type(node).__name__} has the name {name}, as another node has."
        taken.add(name)
    return ""


def core_nodes(task: Task, theme: Theme, seed: int, parts: Parts = OWN_PARTS) -> tuple[Node, ...]:
    """Return the framework's nodes and the task's own perception, in the order in which they
    receive a message.
    """
    seat_of = task.seat_of if len(task.seats) > 1 else None
    perception = (parts.perception(task.parameters, seat_of), *task.nodes())
    return (
        *perception,
        parts.memory(),
        parts.event_handler(task, seed, (*VITAL, *(node.name for node in perception))),
        ActionCenter(task, theme, seed),
        Arbiter(task.parameters, theme),
        OperatorProtocol(),
    )

"""The Arbiter: stands between what the agent proposes and what the participant gets."""

from collections.abc import Callable

from sar_tui.framework.agenda import LASTING, Agenda
from sar_tui.framework.clock import MS, SECOND
from sar_tui.framework.messages import (
    Action,
    AgentActing,
    AttemptEnded,
    Deed,
    Dropped,
    Halt,
    Operator,
    OutputOpened,
    OutputReport,
    Proposal,
    Saying,
    SessionEnded,
    SessionStarted,
    Waiting,
)
from sar_tui.framework.node import TimedNode, on
from sar_tui.framework.topics import (
    ACTING,
    ACTION,
    ATTEMPT_ENDED,
    DROPPED,
    HALT,
    OPERATOR,
    OUTPUT,
    PROPOSED,
    REPORT,
    SESSION,
    SESSION_ENDED,
    TIMER,
    WAITING,
)

PATIENCE = 40 * SECOND
"""An action of which no output says that it is over is halted by then: no session hangs on a robot. Speaking takes
longer with the text; outputs give up sooner (`outputs.node`)."""
PER_CHARACTER = 150 * MS
_OVER = ("done", "aborted", "failed")


class Arbiter(TimedNode):
    """Passes proposals on, one at a time, but none in a trial or a pause: what comes then waits until it is over."""

    name = "arbiter"
    emits = (TIMER, ACTION, DROPPED, HALT, ACTING)

    def __init__(self) -> None:
        super().__init__()
        self._agenda = Agenda()
        self._announced: list[OutputOpened] = []
        self._outputs: list[OutputOpened] = []
        self._is_closed = False
        self._acting = False

    @on(OUTPUT)
    def output_opened(self, opened: OutputOpened) -> None:
        """Outputs announce themselves before a run begins."""
        self._announced.append(opened)

    @on(SESSION)
    def session_started(self, _: SessionStarted) -> None:
        """A run begins: what was under way in another is over."""
        self._outputs, self._announced = self._announced, []
        self.cancel_timers()
        self._agenda.abandon()
        self._drop("late")
        self._is_closed = False
        self._tell_acting()

    @on(WAITING)
    def waiting(self, waiting: Waiting) -> None:
        """Nothing begins in a trial, and a pause is quiet; who goes on from the instructions need not hear them out."""
        in_trial = waiting.what in ("foreperiod", "storage", "response") and waiting.stage == "trial"
        self._is_closed = in_trial or (waiting.stage == "paused" and waiting.reason != "interrupted")
        if waiting.stage == "trial":
            self._drop("late", lambda proposal: proposal.policy == "drop")
        current = self._agenda.current
        if waiting.stage not in ("instructions", "paused"):
            self._drop("late", lambda proposal: proposal.kind == "instruction")
            if current and current.kind == "instruction":
                self.emit(HALT, Halt(action=current.id, reason="left", asked=self.now))
        if waiting.stage == "paused" and self._is_closed and current:
            self.emit(HALT, Halt(action=current.id, reason="left", asked=self.now))
        self._go_on()

    @on(ATTEMPT_ENDED)
    def attempt_ended(self, ended: AttemptEnded) -> None:
        """An attempt that is scored once more is answered anew, if it has not been answered yet."""
        self._drop("amended", lambda proposal: (proposal.kind, proposal.attempt) == ("feedback", ended.attempt))

    @on(SESSION_ENDED)
    def session_ended(self, _: SessionEnded) -> None:
        """Nothing is said after the goodbye."""
        self._drop("late")

    @on(PROPOSED)
    def proposed(self, proposal: Proposal) -> None:
        self._agenda.add(proposal)
        self._go_on()

    @on(REPORT)
    def reported(self, report: OutputReport) -> None:
        if report.state in _OVER and self._agenda.close(report.action, report.output, report.deed):
            self._go_on()

    @on(OPERATOR)
    def operator_acted(self, act: Operator) -> None:
        """The stop key: everything that is said and done, and all that waits for its turn."""
        if act.command == "stop":
            self._drop("stopped")
            self.emit(HALT, Halt(reason="stopped", asked=act.at or self.now))

    def timer(self, name: str, late: int) -> None:
        if name == "patience" and (current := self._agenda.current):
            self.emit(HALT, Halt(action=current.id, reason="interrupted", asked=self.now))
            self._agenda.abandon()
        self._go_on()

    def _go_on(self) -> None:
        """Let those act whose turn it is."""
        while not self._is_closed and (proposal := self._agenda.next(self.now)):
            if current := self._agenda.current:
                self.emit(HALT, Halt(action=current.id, reason="interrupted", asked=self.now))
            self._agenda.begin(proposal, self._parts(proposal))
            self.emit(ACTION, _accepted(proposal))
            self.set_timer("patience", self.now + PATIENCE + PER_CHARACTER * len(proposal.spoken))
        if not self._agenda.is_acting:
            self.cancel_timer("patience")
        if (due := self._agenda.next_due(self.now)) is not None:
            self.set_timer("due", due)
        self._tell_acting()

    def _parts(self, saying: Saying) -> list[tuple[str, Deed]]:
        """Which outputs have something to do for it that takes a while."""
        wanted = {deed for deed in LASTING if getattr(saying, _FIELDS[deed])}
        return [(opened.output, deed) for opened in self._outputs for deed in opened.can if deed in wanted]

    def _tell_acting(self) -> None:
        if self._agenda.is_acting != self._acting:
            self._acting = self._agenda.is_acting
            self.emit(ACTING, AgentActing(acting=self._acting))

    def _drop(self, reason: str, what: Callable[[Proposal], bool] = lambda _: True) -> None:
        for proposal in self._agenda.clear(what):
            self.emit(DROPPED, Dropped(id=proposal.id, reason=reason))  # type: ignore[arg-type]


_FIELDS: dict[Deed, str] = {"say": "spoken", "gesture": "gesture", "gaze": "gaze", "tone": "tone"}
"""What of a saying each deed takes."""


def _accepted(proposal: Proposal) -> Action:
    said = {name: getattr(proposal, name) for name in proposal.__struct_fields__}
    return Action(**said, decision="accepted", actor="agent")

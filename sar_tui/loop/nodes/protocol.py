"""Operator's protocol: tells operators what is due by it, and answers what they tick."""

from msgspec.structs import replace

from sar_tui.loop.answers import answer_to
from sar_tui.loop.node import Node, on
from sar_tui.loop.topics import (
    ANSWERED,
    ATTEMPT_ENDED,
    ATTEMPT_STARTED,
    PROTOCOL,
    PROTOCOL_DUE,
    PROTOCOL_TICKED,
    REASON,
    SESSION,
    SESSION_ENDED,
    STEP_ENDED,
    TRIAL,
    WAITING,
)
from sar_tui.model import messages as m
from sar_tui.model.messages import ActOutcome
from sar_tui.rules.protocol import ProtocolProgress, step


class OperatorProtocol(Node):
    """Follows the session by the protocol that an operator has chosen. Participants see nothing of
    it, and a trial only counts whether it had a response.
    """

    name = "protocol"
    emits = (PROTOCOL_DUE, ANSWERED)

    def __init__(self) -> None:
        super().__init__()
        self._progress = ProtocolProgress()
        self._open: dict[str, m.ProtocolDue] = {}

    @on(SESSION)
    def session_started(self, _: m.SessionStarted) -> None:
        """Tell what is still due in a resumed session: panels know nothing of its earlier runs."""
        for each in self._open.values():
            self._tell(replace(each, at=self.now))

    @on(PROTOCOL)
    def protocol_chosen(self, chosen: m.ProtocolChosen) -> None:
        """Begin with a protocol. What was due by an earlier one is no longer."""
        self._open.clear()
        self._answer(chosen)
        self._step(chosen)

    @on(ATTEMPT_STARTED)
    def attempt_started(self, started: m.AttemptStarted) -> None:
        self._step(started)

    @on(TRIAL)
    def trial_ended(self, trial: m.TrialEnded) -> None:
        if trial.response is None and self._progress.protocol:
            self._step(trial)

    @on(ATTEMPT_ENDED)
    def attempt_ended(self, ended: m.AttemptEnded) -> None:
        self._step(ended)

    @on(STEP_ENDED)
    def question_answered(self, ended: m.StepEnded) -> None:
        self._step(ended)

    @on(WAITING)
    def waiting(self, waiting: m.Waiting) -> None:
        if waiting.stage != "trial" or self._progress.is_paused:
            self._step(waiting)

    @on(SESSION_ENDED)
    def session_ended(self, ended: m.SessionEnded) -> None:
        self._step(ended)

    @on(PROTOCOL_TICKED)
    def ticked(self, ticked: m.ProtocolTicked) -> None:
        """Answer a tick: what is due can be ticked once."""
        if self._open.pop(ticked.due, None):
            self._answer(ticked)
        else:
            self._answer(ticked, "late", "It was ticked already, or is not due.")

    @on(REASON)
    def reason_given(self, given: m.ReasonGiven) -> None:
        """Answer a reason: it is in the record."""
        self._answer(given)

    def _step(self, message: m.Message) -> None:
        self._progress, due = step(self._progress, message, self.now)
        for each in due:
            self._tell(each)

    def _tell(self, due: m.ProtocolDue) -> None:
        self._open[due.id] = due
        self.emit(PROTOCOL_DUE, due)

    def _answer(self, act: m.OperatorAct, outcome: ActOutcome = "done", why: str = "") -> None:
        if act.id:
            self.emit(ANSWERED, answer_to(act, self.now, outcome, why))

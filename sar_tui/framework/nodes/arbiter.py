"""The Arbiter: stands between what the agent proposes and what the participant gets."""

from collections.abc import Callable

from msgspec.structs import replace

from sar_tui.framework import messages as m
from sar_tui.framework.action_queue import LASTING
from sar_tui.framework.actions import edited, initiated
from sar_tui.framework.clock import MS, SECOND
from sar_tui.framework.messages import (
    Action,
    ActionPart,
    Dropped,
    Halt,
    Kind,
    Proposal,
    Utterance,
)
from sar_tui.framework.node import on, serves
from sar_tui.framework.nodes.approvals import Approvals, is_level
from sar_tui.framework.settings.operator import OperatorSettings
from sar_tui.framework.theme import Theme
from sar_tui.framework.topics import (
    ACTING,
    ACTION,
    ARBITER_STATE,
    ATTEMPT_ENDED,
    ATTEMPT_STARTED,
    DECIDED,
    DECISION,
    DROPPED,
    FILLER_DUE,
    HALT,
    LEVEL_DECIDED,
    MISSED,
    MODE,
    OPERATOR,
    OUTPUT,
    PENDING_APPROVAL,
    PRESENCE,
    PROPOSED,
    REMARK,
    REPORT,
    SESSION,
    SESSION_ENDED,
    THEME,
    TIMER,
    UNSAID_FEEDBACK,
    WAITING,
)

PATIENCE = 40 * SECOND
"""An action of which no output says that it is over is halted by then: no session hangs on a robot. Speaking takes
longer with the text; outputs give up sooner (`outputs.node`)."""
PER_CHARACTER = 150 * MS
FILLER_AFTER = SECOND
"""An answer that is owed for longer than this is covered by a filler: people prefer to hear something by then."""
_OVER = ("done", "aborted", "failed")
_AFTER_FEEDBACK: tuple[Kind, ...] = ("encouragement", "rest")
"""What would be odd to hear before the answer that is owed."""


class Arbiter(Approvals):
    """Passes actions to the outputs, one at a time, and none during a trial or a pause: they wait until it is over."""

    name = "arbiter"
    emits = (
        TIMER,
        PENDING_APPROVAL,
        DECIDED,
        LEVEL_DECIDED,
        ACTION,
        DROPPED,
        HALT,
        ACTING,
        FILLER_DUE,
        MISSED,
        ARBITER_STATE,
    )

    def __init__(self, parameters: OperatorSettings, theme: Theme) -> None:
        super().__init__(parameters, theme)
        self._announced: list[m.OutputOpened] = []
        self._outputs: list[m.OutputOpened] = []
        self._is_closed = False
        self._acting = m.AgentActing(acting=False)
        self._state: m.ArbiterState | None = None
        self._has_operators = False
        self._remarks = 0
        self._awaited: tuple[str, ...] = ()

    # --- the session -----------------------------------------------------------------------------------------

    @on(OUTPUT)
    def output_opened(self, opened: m.OutputOpened) -> None:
        """Outputs announce themselves before a run begins."""
        self._announced.append(opened)

    @on(THEME)
    def theme_applied(self, applied: m.ThemeApplied) -> None:
        """Operators' words are said in the manner of the theme."""
        self._theme = applied.theme

    @on(SESSION)
    def session_started(self, _: m.SessionStarted) -> None:
        """A run begins: what was under way in another is over, and so is whoever was there.

        Words that waited are late now; a level that waited is not.
        """
        self._outputs, self._announced = self._announced, []
        self.cancel_timers()
        self._queue.abandon()
        self._do_without_operator(is_level)
        self._drop("late")
        self._rules = replace(self._rules, operated=False)
        self._is_closed = False
        self._publish_state()

    @on(WAITING)
    def waiting(self, waiting: m.Waiting) -> None:
        """Nothing begins in a trial, and a pause is quiet; who goes on from the instructions need not hear them out."""
        in_trial = waiting.what in ("foreperiod", "storage", "response") and waiting.stage == "trial"
        self._is_closed = in_trial or (waiting.stage == "paused" and waiting.reason != "interrupted")
        if waiting.stage == "trial":
            self._drop("late", lambda one: one.policy == "drop")
        current = self._queue.current
        if waiting.stage not in ("instructions", "paused"):
            self._drop("late", lambda one: one.kind == "instruction")
            if current and current.kind == "instruction":
                self.emit(HALT, Halt(action=current.id, reason="left", asked=self.now))
        if waiting.stage == "paused" and self._is_closed and current:
            self.emit(HALT, Halt(action=current.id, reason="left", asked=self.now))
        self._begin_next()

    @on(ATTEMPT_STARTED)
    def attempt_started(self, _: m.AttemptStarted) -> None:
        """What only waited for an operator who might have wanted it is over with the pause between attempts."""
        for pending in self._pending.remove(lambda one: one.deadline is None):
            self._give_up(pending, "manual", "mode")
        self._publish_state()

    @on(ATTEMPT_ENDED)
    def attempt_ended(self, ended: m.AttemptEnded) -> None:
        """An attempt that is scored once more is answered anew, if it has not been answered yet.

        If it comes out another way and no level was asked for with that, the level that waits is not called for.
        """
        self._note_outcome(ended)
        here = (ended.seat, ended.attempt)
        self._drop("amended", lambda one: one.kind == "feedback" and (one.seat, one.attempt) == here)
        self._publish_state()

    @on(SESSION_ENDED)
    def session_ended(self, ended: m.SessionEnded) -> None:
        """Nothing is said after the goodbye; before it, where all was done, the last answers have their turn."""
        answers = [action.id for action in self._queue.waiting if action.kind == "feedback"]
        self._drop("late", lambda one: ended.status == "aborted" or one.id not in answers)
        self._publish_state()

    # --- what the agent proposes -------------------------------------------------------------------------------

    @on(PROPOSED)
    def proposed(self, proposal: Proposal) -> None:
        """A gesture that is ruled on apart is one proposal more."""
        words = self._decide_proposal(proposal)
        self._set_filler_timer(words)
        self._begin_next()

    @serves(UNSAID_FEEDBACK)
    def tell_unsaid(self, asked: m.UnsaidFeedbackRequest) -> m.UnsaidFeedback:
        """Whose answers wait."""
        waiting = (*self._queue.waiting, *(one.proposal for one in self._pending.waiting))
        answers = [one for one in waiting if one.kind == "feedback" and one.attempt == asked.attempt]
        return m.UnsaidFeedback(seats=tuple(sorted({one.seat for one in answers})))

    def _set_filler_timer(self, proposal: Proposal) -> None:
        """A filler covers a wait for an operator; or any, so that it does not tell the two apart."""
        waits = any(one.proposal is proposal and one.deadline is not None for one in self._pending.waiting)
        delayed = proposal.due > self.now + FILLER_AFTER
        wanted = {"operator": waits, "always": waits or delayed, "never": False}[self._parameters.filler]
        if proposal.kind == "feedback" and wanted:
            self._awaited = (*filter(self._is_awaited, self._awaited), proposal.id)
            self.set_timer("filler", self.now + FILLER_AFTER)

    # --- what operators do ---------------------------------------------------------------------------------------

    @on(PRESENCE)
    def operator_changed(self, changed: m.OperatorChanged) -> None:
        """Without an operator, what waits for one is done or left out, as the session is set."""
        self._has_operators = True
        self._apply_presence(changed.operated)
        self._begin_next()

    @on(MODE)
    def mode_chosen(self, chosen: m.ModeChanged) -> None:
        """What waits already is ruled on anew."""
        self._has_operators = True
        self._apply_mode(chosen)
        self._begin_next()

    @on(DECISION)
    def decided(self, decision: m.Decision) -> None:
        """An operator decides: on what waits for them, on what waits for its turn, or on what is under way."""
        if pending := self._pending.take(decision.action):
            self._apply_decision(pending, decision)
        elif queued := self._queue.take(decision.action):
            self._decide_queued(queued, decision)
        elif (current := self._queue.current) and current.id == decision.action and decision.verdict == "veto":
            self.emit(HALT, Halt(action=current.id, reason="vetoed", asked=decision.at or self.now))
        else:
            why = "It was decided, or its time was over."
            self.emit(MISSED, m.ActMissed(actor=decision.actor, what=f"{decision.verdict} {decision.action}", why=why))
        self._begin_next()

    @on(REMARK)
    def remarked(self, remark: m.Remark) -> None:
        """An operator's own words or gesture take their turn before all that the agent proposes."""
        self._remarks += 1
        said = initiated(remark, f"o{self._remarks}", self._theme, self.now)
        self._queue.add(said)
        self.emit(DECIDED, said)
        self._begin_next()

    @on(OPERATOR)
    def operator_acted(self, act: m.Operator) -> None:
        """The stop key: everything that is said and done, and all that waits. A level by hand is the one that holds."""
        if act.command == "stop":
            self._drop("stopped", actor=act.actor)
            self.emit(HALT, Halt(reason="stopped", asked=act.at or self.now))
        elif act.command == "level":
            for pending in self._pending.remove(is_level):
                self._decide_level(pending, "rejected", 0, act.actor, "operator")
        self._publish_state()

    def _decide_queued(self, queued: Action, decision: m.Decision) -> None:
        if decision.verdict == "veto":
            self.emit(DROPPED, Dropped(id=queued.id, reason="vetoed", actor=decision.actor))
            return
        if decision.verdict == "edit":
            queued = edited(queued, decision, self._theme, self.now)
            self.emit(DECIDED, queued)
        self._queue.add(queued)

    # --- whose turn it is --------------------------------------------------------------------------------------

    @on(REPORT)
    def reported(self, report: m.OutputReport) -> None:
        if report.state in _OVER and self._queue.finish_part(report.action, report.output, report.part):
            self._begin_next()

    def timer(self, name: str, late: int) -> None:
        if name == "patience" and (current := self._queue.current):
            self.emit(HALT, Halt(action=current.id, reason="interrupted", asked=self.now))
            self._queue.abandon()
        elif name == "filler" and (owed := next(filter(self._is_awaited, self._awaited), None)):
            self.emit(FILLER_DUE, m.FillerDue(id=owed))
        elif name == "deadline":
            self._apply_deadlines()
        self._begin_next()

    def _is_awaited(self, id: str) -> bool:
        return any(one.proposal.id == id for one in self._pending.waiting) or any(
            action.id == id for action in self._queue.waiting
        )

    def _begin_next(self) -> None:
        """Let those act whose turn it is."""
        held = _AFTER_FEEDBACK if self._pending.is_awaited else ()
        while not self._is_closed and (action := self._queue.next(self.now, held)):
            if current := self._queue.current:
                self.emit(HALT, Halt(action=current.id, reason="interrupted", asked=self.now))
            self._queue.begin(action, self._parts(action))
            self.emit(ACTION, action)
            self.set_timer("patience", self.now + PATIENCE + PER_CHARACTER * len(action.spoken))
        if not self._queue.is_acting:
            self.cancel_timer("patience")
        if (due := self._queue.next_due(self.now)) is not None:
            self.set_timer("due", due)
        if (deadline := self._pending.next_deadline) is not None:
            self.set_timer("deadline", deadline)
        else:
            self.cancel_timer("deadline")
        self._publish_state()

    def _parts(self, utterance: Utterance) -> list[tuple[str, ActionPart]]:
        """Which outputs have something to do for it that takes a while."""
        wanted = {part for part in LASTING if getattr(utterance, _FIELDS[part])}
        return [(opened.output, part) for opened in self._outputs for part in opened.can if part in wanted]

    def _publish_state(self) -> None:
        """Tell what is another than before: whether the agent acts; and to operators, how things stand."""
        acting = m.AgentActing(acting=self._queue.is_acting, awaits_operator=self._pending.is_awaited)
        if acting != self._acting:
            self._acting = acting
            self.emit(ACTING, acting)
        if not self._has_operators:
            return
        state = m.ArbiterState(
            modes=self._rules.modes,
            operated=self._rules.operated,
            pending=self._pending.waiting,
            queued=self._queue.waiting,
            current=self._queue.current,
        )
        if state != self._state:
            self._state = state
            self.emit(ARBITER_STATE, state)

    def _drop(self, reason: str, what: Callable[[Utterance], bool] = lambda _: True, actor: str = "agent") -> None:
        for action in self._queue.remove(what):
            self.emit(DROPPED, Dropped(id=action.id, reason=reason, actor=_who(reason, actor)))  # type: ignore[arg-type]
        for pending in self._pending.remove(lambda one: what(one.proposal)):
            self._give_up(pending, reason, "mode", _who(reason, actor))


_FIELDS: dict[ActionPart, str] = {"say": "spoken", "gesture": "gesture", "gaze": "gaze", "tone": "tone"}
"""What of a saying each part takes."""


def _who(reason: str, actor: str) -> str:
    """Who dropped something: the participant's own stop key, and the agent, are not named."""
    return actor if reason == "stopped" and actor != "participant" else "agent"

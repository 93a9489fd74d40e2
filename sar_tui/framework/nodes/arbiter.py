"""The Arbiter: stands between what the agent proposes and what the participant gets."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import msgspec

from sar_tui.framework import messages as m
from sar_tui.framework.action_queue import LASTING, ActionQueue
from sar_tui.framework.clock import MS, SECOND
from sar_tui.framework.messages import (
    Action,
    ActionPart,
    Dropped,
    Ground,
    Halt,
    Kind,
    PendingApproval,
    Proposal,
    Utterance,
)
from sar_tui.framework.node import TimedNode, on, serves
from sar_tui.framework.parameters import TaskParameters
from sar_tui.framework.pending_approvals import PendingApprovals, accepted, edited
from sar_tui.framework.policies import arbitration
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
    LEVEL_REQUEST,
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
STALLS_AFTER = SECOND
"""An answer that is owed for longer than this is covered by a filler: people prefer to hear something by then."""
OPERATORS_FIRST = 50
"""How important an operator's own words are: more than anything the agent proposes."""
_OVER = ("done", "aborted", "failed")
_AFTER_ANSWER: tuple[Kind, ...] = ("encouragement", "rest")
"""What would be odd to hear before the answer that is owed."""


class _Scored(NamedTuple):
    """How an attempt came out at a seat, and how many levels had been asked for by then."""

    outcome: m.Outcome
    levels: int


class Arbiter(TimedNode):
    """Passes proposals on, one at a time, but none in a trial or a pause: what comes then waits until it is over.

    Where an operator has a say, a proposal is offered to them first (see `policies.arbitration`).
    """

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

    def __init__(self, parameters: TaskParameters, theme: Theme) -> None:
        super().__init__()
        self._parameters = parameters
        self._theme = theme
        self._rules = arbitration.start(parameters)
        self._offers = PendingApprovals()
        self._queue = ActionQueue()
        self._announced: list[m.OutputOpened] = []
        self._outputs: list[m.OutputOpened] = []
        self._is_closed = False
        self._acting = m.AgentActing(acting=False)
        self._standing: m.ArbiterState | None = None
        self._has_operators = False
        self._remarks = self._levels = 0
        self._stalling: tuple[str, ...] = ()
        self._scored: dict[tuple[str, int], _Scored] = {}

    # --- the session -----------------------------------------------------------------------------------------

    @on(OUTPUT)
    def output_opened(self, opened: m.OutputOpened) -> None:
        """Outputs announce themselves before a run begins."""
        self._announced.append(opened)

    @on(THEME)
    def wear(self, worn: m.ThemeApplied) -> None:
        """Operators' words are said in the manner of the theme."""
        self._theme = worn.theme

    @on(SESSION)
    def session_started(self, _: m.SessionStarted) -> None:
        """A run begins: what was under way in another is over, and so is whoever was there.

        Words that waited are late now; a level that waited is not.
        """
        self._outputs, self._announced = self._announced, []
        self.cancel_timers()
        self._queue.abandon()
        for offer in self._offers.clear(lambda offer: offer.level is not None):
            self._do_without_operator(offer)
        self._drop("late")
        self._rules = msgspec.structs.replace(self._rules, operated=False)
        self._is_closed = False
        self._tell()

    @on(WAITING)
    def waiting(self, waiting: m.Waiting) -> None:
        """Nothing begins in a trial, and a pause is quiet; who goes on from the instructions need not hear them out."""
        in_trial = waiting.what in ("foreperiod", "storage", "response") and waiting.stage == "trial"
        self._is_closed = in_trial or (waiting.stage == "paused" and waiting.reason != "interrupted")
        if waiting.stage == "trial":
            self._drop("late", lambda saying: saying.policy == "drop")
        current = self._queue.current
        if waiting.stage not in ("instructions", "paused"):
            self._drop("late", lambda saying: saying.kind == "instruction")
            if current and current.kind == "instruction":
                self.emit(HALT, Halt(action=current.id, reason="left", asked=self.now))
        if waiting.stage == "paused" and self._is_closed and current:
            self.emit(HALT, Halt(action=current.id, reason="left", asked=self.now))
        self._go_on()

    @on(ATTEMPT_STARTED)
    def attempt_started(self, _: m.AttemptStarted) -> None:
        """What only waited for an operator who might have wanted it is over with the pause between attempts."""
        for offer in self._offers.clear(lambda offer: offer.deadline is None):
            self._give_up(offer, "manual", "mode")
        self._tell()

    @on(ATTEMPT_ENDED)
    def attempt_ended(self, ended: m.AttemptEnded) -> None:
        """An attempt that is scored once more is answered anew, if it has not been answered yet.

        If it comes out another way and no level was asked for with that, the level that waits is not called for.
        """
        here = (ended.seat, ended.attempt)
        known = {at: scored for at, scored in self._scored.items() if at[1] == ended.attempt}
        self._scored = {**known, here: _Scored(ended.outcome, self._levels)}
        comes_out_otherwise = here in known and _is_failure(known) != _is_failure(self._scored)
        if comes_out_otherwise and known[here].levels == self._levels:
            for offer in self._offers.clear(lambda offer: offer.level is not None):
                self._give_up(offer, "amended", "mode")
        self._drop("amended", lambda saying: saying.kind == "feedback" and (saying.seat, saying.attempt) == here)
        self._tell()

    @on(SESSION_ENDED)
    def session_ended(self, ended: m.SessionEnded) -> None:
        """Nothing is said after the goodbye; before it, where all was done, the last answers have their turn."""
        answers = [action.id for action in self._queue.waiting if action.kind == "feedback"]
        self._drop("late", lambda saying: ended.status == "aborted" or saying.id not in answers)
        self._tell()

    # --- what the agent proposes -------------------------------------------------------------------------------

    @on(PROPOSED)
    def proposed(self, proposal: Proposal) -> None:
        """A gesture that is ruled on apart is one proposal more."""
        if arbitration.is_apart(self._rules, self._parameters, proposal):
            apart = _gesture_of(proposal)
            proposal = msgspec.structs.replace(proposal, gesture="")
            self._rule(proposal)
            if self._rules.operated:
                self._rule(apart)
        else:
            self._rule(proposal)
        self._expect_stall(proposal)
        self._go_on()

    @serves(LEVEL_REQUEST)
    def rule_on_level(self, asked: m.LevelRequest) -> m.LevelReply:
        """A change of level: it happens, or an operator is asked; after the last attempt it happens, or does not."""
        change = asked.change
        told = f"Level {change.previous} → {change.level}"
        proposal = Proposal(seat=change.seat, id=f"l{self._levels + 1}", kind="difficulty", text=told)
        if asked.is_last:
            verdict = arbitration.rule(self._rules, self._parameters, proposal, self.now)
            return m.LevelReply(happens=verdict.what == "act")
        self._levels += 1
        for offer in self._offers.clear(lambda offer: offer.level is not None):
            self._give_up(offer, "amended", "mode")
        verdict = arbitration.rule(self._rules, self._parameters, proposal, self.now, change.level)
        if verdict.offer:
            self._offer(verdict.offer)
        elif verdict.what == "drop":
            self._rule_level(
                PendingApproval(proposal=proposal, mode=self._rules.mode("difficulty")), "rejected", change.previous
            )
        self._tell()
        return m.LevelReply(happens=verdict.what == "act")

    @serves(UNSAID_FEEDBACK)
    def tell_unsaid(self, asked: m.UnsaidFeedbackRequest) -> m.UnsaidFeedback:
        """Whose answers wait."""
        waiting = (*self._queue.waiting, *(offer.proposal for offer in self._offers.waiting))
        answers = [saying for saying in waiting if saying.kind == "feedback" and saying.attempt == asked.attempt]
        return m.UnsaidFeedback(seats=tuple(sorted({saying.seat for saying in answers})))

    def _rule(self, proposal: Proposal) -> None:
        verdict = arbitration.rule(self._rules, self._parameters, proposal, self.now)
        match verdict.what:
            case "act":
                self._queue.add(accepted(proposal, ground=verdict.ground))
            case "drop":
                self.emit(DROPPED, Dropped(id=proposal.id, reason="no operator"))
            case "offer" if verdict.offer:
                self._offer(verdict.offer)

    def _offer(self, offer: PendingApproval) -> None:
        self._offers.add(offer)
        self.emit(PENDING_APPROVAL, offer)

    def _expect_stall(self, proposal: Proposal) -> None:
        """A filler covers a wait for an operator; or any, so that it does not tell the two apart."""
        offered = any(offer.proposal is proposal and offer.deadline is not None for offer in self._offers.waiting)
        delayed = proposal.due > self.now + STALLS_AFTER
        wanted = {"operator": offered, "always": offered or delayed, "never": False}[self._parameters.filler]
        if proposal.kind == "feedback" and wanted:
            self._stalling = (*filter(self._is_owed, self._stalling), proposal.id)
            self.set_timer("filler", self.now + STALLS_AFTER)

    # --- what operators do ---------------------------------------------------------------------------------------

    @on(PRESENCE)
    def operator_changed(self, changed: m.OperatorChanged) -> None:
        """Without an operator, what waits for one is done or left out, as the session is set."""
        self._has_operators = True
        self._rules = msgspec.structs.replace(self._rules, operated=changed.operated)
        if not changed.operated:
            for offer in self._offers.clear():
                self._do_without_operator(offer)
        self._go_on()

    @on(MODE)
    def mode_chosen(self, chosen: m.ModeChanged) -> None:
        """What waits already is ruled on anew."""
        self._has_operators = True
        self._rules = arbitration.choose(self._rules, chosen.kind, chosen.mode)
        for offer in self._offers.clear(lambda offer: arbitration.RULED[offer.proposal.kind] == chosen.kind):
            verdict = arbitration.rule(self._rules, self._parameters, offer.proposal, self.now, offer.level)
            if verdict.offer:
                self._offer(verdict.offer)
            else:
                self._act(offer, chosen.actor, "operator")
        self._go_on()

    @on(DECISION)
    def decided(self, decision: m.Decision) -> None:
        """An operator decides: on what waits for them, on what waits for its turn, or on what is under way."""
        if offer := self._offers.take(decision.action):
            self._decide(offer, decision)
        elif queued := self._queue.take(decision.action):
            self._decide_queued(queued, decision)
        elif (current := self._queue.current) and current.id == decision.action and decision.verdict == "veto":
            self.emit(HALT, Halt(action=current.id, reason="vetoed", asked=decision.at or self.now))
        else:
            why = "It was decided, or its time was over."
            self.emit(MISSED, m.ActMissed(actor=decision.actor, what=f"{decision.verdict} {decision.action}", why=why))
        self._go_on()

    @on(REMARK)
    def remarked(self, remark: m.Remark) -> None:
        """An operator's own words or gesture take their turn before all that the agent proposes."""
        self._remarks += 1
        manner = self._theme.manner(remark.valence or "remark")
        said = Action(
            seat=remark.seat,
            id=f"o{self._remarks}",
            kind="remark" if remark.text else "gesture",
            text=remark.text,
            spoken=self._theme.spoken(remark.text),
            face=remark.face or (manner.face if remark.text else ""),
            gesture=remark.gesture or (manner.gesture if remark.valence else ""),
            gaze=remark.gaze or ("ahead" if remark.text else ""),
            tone=manner.tone if remark.valence else "",
            valence=remark.valence,
            priority=OPERATORS_FIRST,
            decision="initiated",
            actor=remark.actor,
            mode="manual",
            ground="operator",
            decided=self.now,
        )
        self._queue.add(said)
        self.emit(DECIDED, said)
        self._go_on()

    @on(OPERATOR)
    def operator_acted(self, act: m.Operator) -> None:
        """The stop key: everything that is said and done, and all that waits. A level by hand is the one that holds."""
        if act.command == "stop":
            self._drop("stopped", actor=act.actor)
            self.emit(HALT, Halt(reason="stopped", asked=act.at or self.now))
        elif act.command == "level":
            for offer in self._offers.clear(lambda offer: offer.level is not None):
                self._rule_level(offer, "rejected", 0, act.actor, "operator")
        self._tell()

    def _decide(self, offer: PendingApproval, decision: m.Decision) -> None:
        if decision.verdict == "veto":
            self._give_up(offer, "vetoed", "operator", decision.actor)
        elif offer.level is not None:
            level = offer.level if decision.verdict == "accept" or decision.level is None else decision.level
            how = "accepted" if level == offer.level else "edited"
            self._rule_level(offer, how, level, decision.actor, "operator")
        elif decision.verdict == "edit":
            action = accepted(offer.proposal, offer=offer)
            self._take_turn(edited(action, decision, self._theme, self.now))
        else:
            self._act(offer, decision.actor, "operator")

    def _decide_queued(self, queued: Action, decision: m.Decision) -> None:
        if decision.verdict == "veto":
            self.emit(DROPPED, Dropped(id=queued.id, reason="vetoed", actor=decision.actor))
            return
        if decision.verdict == "edit":
            queued = edited(queued, decision, self._theme, self.now)
            self.emit(DECIDED, queued)
        self._queue.add(queued)

    def _act(self, offer: PendingApproval, actor: str, ground: Ground) -> None:
        """Do what was offered, as it was proposed."""
        if offer.level is not None:
            self._rule_level(offer, "accepted", offer.level, actor, ground)
        else:
            self._take_turn(accepted(offer.proposal, actor, ground, offer, self.now))

    def _do_without_operator(self, offer: PendingApproval) -> None:
        if self._parameters.operator_lost == "autonomous":
            self._act(offer, "agent", "no operator")
        else:
            self._give_up(offer, "no operator", "no operator")

    def _take_turn(self, action: Action) -> None:
        """It is decided, and waits for its turn; what was to cover the wait is needed no more."""
        for filler in self._queue.clear(lambda waiting: waiting.kind == "filler"):
            self.emit(DROPPED, Dropped(id=filler.id, reason="late"))
        self._queue.add(action)
        self.emit(DECIDED, action)

    def _give_up(self, offer: PendingApproval, reason: str, ground: Ground, actor: str = "agent") -> None:
        """Leave out what was offered."""
        if offer.level is not None:
            self._rule_level(offer, "rejected", 0, actor, ground)
        else:
            self.emit(DROPPED, Dropped(id=offer.proposal.id, reason=reason, actor=actor))  # type: ignore[arg-type]

    def _rule_level(
        self, offer: PendingApproval, decision: str, level: int, actor: str = "agent", ground: Ground = "no operator"
    ) -> None:
        ruled = m.LevelDecided(
            seat=offer.seat,
            id=offer.proposal.id,
            level=level,
            decision=decision,  # type: ignore[arg-type]
            actor=actor,
            ground=ground,
            at=self.now,
        )
        self.emit(LEVEL_DECIDED, ruled)

    # --- whose turn it is --------------------------------------------------------------------------------------

    @on(REPORT)
    def reported(self, report: m.OutputReport) -> None:
        if report.state in _OVER and self._queue.close(report.action, report.output, report.deed):
            self._go_on()

    def timer(self, name: str, late: int) -> None:
        if name == "patience" and (current := self._queue.current):
            self.emit(HALT, Halt(action=current.id, reason="interrupted", asked=self.now))
            self._queue.abandon()
        elif name == "filler" and (owed := next(filter(self._is_owed, self._stalling), None)):
            self.emit(FILLER_DUE, m.FillerDue(id=owed))
        elif name == "deadline":
            self._decide_without_operator()
        self._go_on()

    def _decide_without_operator(self) -> None:
        for offer in self._offers.take_due(self.now):
            if offer.otherwise == "act":
                self._act(offer, "agent", "deadline")
            else:
                self._give_up(offer, "expired", "deadline")

    def _is_owed(self, id: str) -> bool:
        return any(offer.proposal.id == id for offer in self._offers.waiting) or any(
            action.id == id for action in self._queue.waiting
        )

    def _go_on(self) -> None:
        """Let those act whose turn it is."""
        held = _AFTER_ANSWER if self._offers.is_owing else ()
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
        if (deadline := self._offers.next_deadline) is not None:
            self.set_timer("deadline", deadline)
        else:
            self.cancel_timer("deadline")
        self._tell()

    def _parts(self, saying: Utterance) -> list[tuple[str, ActionPart]]:
        """Which outputs have something to do for it that takes a while."""
        wanted = {deed for deed in LASTING if getattr(saying, _FIELDS[deed])}
        return [(opened.output, deed) for opened in self._outputs for deed in opened.can if deed in wanted]

    def _tell(self) -> None:
        """Tell what is another than before: whether the agent acts; and to operators, how things stand."""
        acting = m.AgentActing(acting=self._queue.is_acting, owing=self._offers.is_owing)
        if acting != self._acting:
            self._acting = acting
            self.emit(ACTING, acting)
        if not self._has_operators:
            return
        standing = m.ArbiterState(
            modes=self._rules.modes,
            operated=self._rules.operated,
            offers=self._offers.waiting,
            queued=self._queue.waiting,
            current=self._queue.current,
        )
        if standing != self._standing:
            self._standing = standing
            self.emit(ARBITER_STATE, standing)

    def _drop(self, reason: str, what: Callable[[Utterance], bool] = lambda _: True, actor: str = "agent") -> None:
        for action in self._queue.clear(what):
            self.emit(DROPPED, Dropped(id=action.id, reason=reason, actor=_who(reason, actor)))  # type: ignore[arg-type]
        for offer in self._offers.clear(lambda offer: what(offer.proposal)):
            self._give_up(offer, reason, "mode", _who(reason, actor))


_FIELDS: dict[ActionPart, str] = {"say": "spoken", "gesture": "gesture", "gaze": "gaze", "tone": "tone"}
"""What of a saying each deed takes."""


def _is_failure(scored: Mapping[tuple[str, int], _Scored]) -> bool:
    """Whether an attempt counts as a failure for the level: where one of those who took part failed."""
    return any(one.outcome == "failure" for one in scored.values())


def _who(reason: str, actor: str) -> str:
    """Who dropped something: the participant's own stop key, and the agent, are not named."""
    return actor if reason == "stopped" and actor != "participant" else "agent"


def _gesture_of(proposal: Proposal) -> Proposal:
    """A proposal's gesture alone."""
    return msgspec.structs.replace(
        proposal,
        id=f"{proposal.id}.gesture",
        kind="gesture",
        text="",
        spoken="",
        face="",
        gaze="",
        tone="",
        policy="drop",
        joins=True,
    )

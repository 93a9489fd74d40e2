"""The Arbiter: decides when proposals of the agent reach the outputs."""

from collections.abc import Callable

from msgspec.structs import replace

from sar_tui.loop.action_queue import LASTING, ActionQueue, edited, initiated
from sar_tui.loop.agent_state import AWAITED
from sar_tui.loop.answers import OpenActs, Part, answer_to
from sar_tui.loop.approvals import Approvals
from sar_tui.loop.node import TimedNode, on, serves
from sar_tui.loop.topics import (
    ACTING,
    ACTION,
    ANSWERED,
    ARBITER_STATE,
    ATTEMPT_ENDED,
    ATTEMPT_STARTED,
    COMMAND,
    DECIDED,
    DECISION,
    DROPPED,
    FILLER_DUE,
    HALT,
    LATE_DECISION,
    LEVEL_DECIDED,
    LEVEL_REQUEST,
    MODE,
    NOTE_ADDED,
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
from sar_tui.model import messages as m
from sar_tui.model.messages import Action, ActionPart, Dropped, Halt, Proposal, Utterance
from sar_tui.model.step import Entry
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.rules.parameters import TaskParameters

ACTION_TIMEOUT = 40 * SECOND
"""An action that no output reports as over is halted after this time, so that no robot blocks a
session. Spoken text adds `PER_CHARACTER`; outputs give up sooner (`outputs.node`).
"""
PER_CHARACTER = 150 * MS
FILLER_AFTER = SECOND
"""A wait for feedback that is longer than this is covered by a filler."""
_OVER = ("done", "aborted", "failed")
_DROPPED_BECAUSE = {
    "late": "The session had moved on.",
    "stopped": "The agent was stopped.",
    "vetoed": "It was cancelled.",
}
"""Why a remark was not said, by the reason for which it was dropped."""


class Arbiter(TimedNode):
    """Passes actions to the outputs, one at a time. Actions wait until a trial or a pause is
    over; proposals, if an operator is to decide, in `Approvals`.
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
        LATE_DECISION,
        ARBITER_STATE,
        ANSWERED,
    )

    def __init__(self, parameters: TaskParameters, theme: Theme) -> None:
        super().__init__()
        self._parameters = parameters
        self._theme = theme
        self._queue = ActionQueue()
        self._approvals = Approvals(self, self._queue, parameters)
        self._announced: list[m.OutputOpened] = []
        self._outputs: list[m.OutputOpened] = []
        self._is_held_back = False
        self._acting = m.AgentActing(acting=False)
        self._state: m.ArbiterState | None = None
        self._has_operators = False
        self._remarks = 0
        self._open_acts = OpenActs(lambda answer: self.emit(ANSWERED, answer))
        self._awaited: tuple[str, ...] = ()
        self._given = (0, "")
        """Attempt and seat of the feedback that was given last."""

    # --- the session

    @on(OUTPUT)
    def output_opened(self, opened: m.OutputOpened) -> None:
        """Store an output. Outputs announce themselves before a run begins."""
        self._announced.append(opened)

    @on(THEME)
    def theme_applied(self, applied: m.ThemeApplied) -> None:
        """Use the theme for operators' remarks."""
        self._theme = applied.theme

    @on(SESSION)
    def session_started(self, _: m.SessionStarted) -> None:
        """Begin a run: drop actions of the last run, and decide a pending level without an
        operator.
        """
        self._outputs, self._announced = self._announced, []
        self.cancel_timers()
        self._queue.abandon()
        self._open_acts.forget()
        self._approvals.begin_run()
        self._drop("late")
        self._is_held_back = False
        self._publish_state()

    @on(WAITING)
    def waiting(self, waiting: m.Waiting) -> None:
        """Hold back actions in trials and pauses; stop the instructions when the participant leaves
        them.
        """
        in_trial = waiting.what in AWAITED and waiting.stage == "trial"
        self._is_held_back = in_trial or (
            waiting.stage == "paused" and waiting.reason != "interrupted"
        )
        if not self._is_idle:  # in trials it nearly always is
            self._make_way(waiting)
        self._begin_next()

    def _make_way(self, waiting: m.Waiting) -> None:
        """Drop or halt what must not be heard or seen in this phase."""
        if waiting.stage == "trial" and waiting.what != "agent":
            self._drop("late", lambda one: one.policy == "drop")
        current = self._queue.current
        # its question may be heard to the end
        is_asked = waiting.step is not None and waiting.step.entry != Entry()
        if waiting.stage not in ("instructions", "paused") and not is_asked:
            self._drop("late", lambda one: one.kind == "instruction")
            if current and current.kind == "instruction":
                self.emit(HALT, Halt(action=current.id, reason="left", asked=self.now))
        if waiting.stage == "paused" and self._is_held_back and current:
            self.emit(HALT, Halt(action=current.id, reason="left", asked=self.now))

    @on(ATTEMPT_STARTED)
    def attempt_started(self, _: m.AttemptStarted) -> None:
        """Drop manual proposals when an attempt starts."""
        self._approvals.begin_attempt()
        self._publish_state()

    @on(ATTEMPT_ENDED)
    def attempt_ended(self, ended: m.AttemptEnded) -> None:
        """Drop feedback that waits if its attempt is scored again, and a pending level if the
        outcome changed.
        """
        self._approvals.note_outcome(ended)
        here = (ended.seat, ended.attempt)
        self._drop(
            "amended", lambda one: one.kind == "feedback" and (one.seat, one.attempt) == here
        )
        self._publish_state()

    @on(SESSION_ENDED)
    def session_ended(self, ended: m.SessionEnded) -> None:
        """Drop what waits, except the last feedback if the session was completed: it precedes the
        goodbye.
        """
        if ended.status == "completed":
            self._approvals.complete()
            for action in self._queue.remove(lambda one: one.kind == "feedback"):
                self._queue.add(replace(action, due=0))
        feedback = [action.id for action in self._queue.waiting if action.kind == "feedback"]
        self._drop("late", lambda one: ended.status != "completed" or one.id not in feedback)
        self._publish_state()

    # --- proposals

    @on(PROPOSED)
    def proposed(self, proposal: Proposal) -> None:
        """Decide on a proposal."""
        words = self._approvals.propose(proposal)
        self._set_filler_timer(words)
        self._begin_next()

    @serves(LEVEL_REQUEST)
    def level_requested(self, request: m.LevelRequest) -> m.LevelReply:
        """Allow a change of level, refuse it, or ask an operator."""
        reply = self._approvals.request_level(request)
        self._publish_state()
        return reply

    @serves(UNSAID_FEEDBACK)
    def unsaid_requested(self, request: m.UnsaidFeedbackRequest) -> m.UnsaidFeedback:
        """Return the seats whose feedback on an attempt waits."""
        waiting = (*self._queue.waiting, *(one.proposal for one in self._approvals.waiting))
        feedback = [
            one for one in waiting if one.kind == "feedback" and one.attempt == request.attempt
        ]
        return m.UnsaidFeedback(seats=tuple(sorted({one.seat for one in feedback})))

    def _set_filler_timer(self, proposal: Proposal) -> None:
        """Schedule a filler for a wait for an operator; or for any wait, so that it does not reveal
        an operator.
        """
        waits = any(
            one.proposal is proposal and one.deadline is not None for one in self._approvals.waiting
        )
        delayed = proposal.due > self.now + FILLER_AFTER
        wanted = {"operator": waits, "always": waits or delayed, "never": False}[
            self._parameters.filler
        ]
        if proposal.kind == "feedback" and wanted:
            self._awaited = (*filter(self._is_awaited, self._awaited), proposal.id)
            self.set_timer("filler", self.now + FILLER_AFTER)

    # --- operators

    @on(PRESENCE)
    def operator_changed(self, changed: m.OperatorChanged) -> None:
        """Apply the presence of operators. Without one, pending proposals are done or dropped, as
        configured.
        """
        self._has_operators = True
        self._approvals.set_presence(is_operated=changed.operated)
        self._begin_next()

    @on(MODE)
    def mode_chosen(self, chosen: m.ModeChanged) -> None:
        """Apply a new mode."""
        self._has_operators = True
        self._approvals.set_mode(chosen)
        self._begin_next()
        self._answer(chosen)

    @on(NOTE_ADDED)
    def note_added(self, note: m.NoteAdded) -> None:
        """Answer a note: it is in the record."""
        self._answer(note)

    @on(DECISION)
    def decided(self, decision: m.Decision) -> None:
        """Apply an operator's decision to a pending, queued or current action."""
        if self._approvals.apply_decision(decision, self._theme):
            self._answer(decision)
        elif decision.verdict == "accept":
            self._decided_late(decision)
        elif queued := self._queue.take(decision.action):
            self._decide_queued(queued, decision)
        elif (
            (current := self._queue.current)
            and current.id == decision.action
            and decision.verdict == "veto"
        ):
            self.emit(HALT, Halt(action=current.id, reason="vetoed", asked=decision.at or self.now))
            self._open_acts.add_halt(current.id, decision, self.now, self._queue.open_parts)
        else:
            self._decided_late(decision)
        self._begin_next()

    def _decided_late(self, decision: m.Decision) -> None:
        why = "It was decided, or its time was over."
        what = f"{decision.verdict} {decision.action}"
        self.emit(LATE_DECISION, m.LateDecision(actor=decision.actor, what=what, why=why))
        self._answer(decision, "late", why)

    def _answer(self, act: m.OperatorAct, outcome: m.ActOutcome = "done", why: str = "") -> None:
        if act.id:
            self.emit(ANSWERED, answer_to(act, self.now, outcome, why))

    @on(REMARK)
    def remarked(self, remark: m.Remark) -> None:
        """Queue an operator's own words or gesture before anything the agent proposes."""
        self._remarks += 1
        action = initiated(remark, f"o{self._remarks}", self._theme, self.now)
        self._queue.add(action)
        self._open_acts.add_request(action.id, remark, self.now)
        self.emit(DECIDED, action)
        self._begin_next()

    @on(COMMAND)
    def command_received(self, act: m.SessionCommand) -> None:
        """Stop and drop everything on the stop key; drop a pending level when an operator sets the
        level.
        """
        if act.command == "stop":
            self._drop("stopped", actor=act.actor)
            self.emit(HALT, Halt(reason="stopped", asked=act.at or self.now))
            self._answer(act)
        elif act.command == "level":
            self._approvals.reject_level(act.actor)
        self._publish_state()

    def _decide_queued(self, queued: Action, decision: m.Decision) -> None:
        self._answer(decision)
        if decision.verdict == "veto":
            self._emit_dropped(queued, "vetoed", decision.actor)
            return
        if decision.verdict == "edit":
            queued = edited(queued, decision, self._theme, self.now)
            self.emit(DECIDED, queued)
        self._queue.add(queued)

    # --- turns

    @on(REPORT)
    def reported(self, report: m.OutputReport) -> None:
        self._open_acts.report(report)
        if report.state in _OVER and self._queue.finish_part(
            report.action, report.output, report.part
        ):
            self._begin_next()

    def timer(self, name: str, late: int) -> None:
        if name == "patience" and (current := self._queue.current):
            self.emit(HALT, Halt(action=current.id, reason="interrupted", asked=self.now))
            self._queue.abandon()
            self._open_acts.give_up(current.id, "refused", "No output has reported its end.")
        elif name == "filler" and (awaited := next(filter(self._is_awaited, self._awaited), None)):
            self.emit(FILLER_DUE, m.FillerDue(id=awaited))
        elif name == "deadline":
            self._approvals.apply_deadlines()
        self._begin_next()

    def _is_awaited(self, id: str) -> bool:
        return any(one.proposal.id == id for one in self._approvals.waiting) or any(
            action.id == id for action in self._queue.waiting
        )

    def _begin_next(self) -> None:
        """Begin the actions whose turn it is."""
        if self._is_idle:
            self.cancel_timer("patience")
            self.cancel_timer("deadline")
            self._publish_state()
            return
        held = self._approvals.kinds_held_back
        while not self._is_held_back and (action := self._queue.next(self.now, held)):
            if current := self._queue.current:
                self.emit(HALT, Halt(action=current.id, reason="interrupted", asked=self.now))
            parts = self._parts(action)
            self._queue.begin(action, [each for each in parts if each[1] in LASTING])
            self.emit(ACTION, self._in_turn(action))
            self._open_acts.begin(action.id, parts)
            self.set_timer(
                "patience", self.now + ACTION_TIMEOUT + PER_CHARACTER * len(action.spoken)
            )
        if not self._queue.is_acting:
            self.cancel_timer("patience")
        if (due := self._queue.next_due(self.now)) is not None:
            self.set_timer("due", due)
        if (deadline := self._approvals.next_deadline) is not None:
            self.set_timer("deadline", deadline)
        else:
            self.cancel_timer("deadline")
        self._publish_state()

    def _in_turn(self, action: Action) -> Action:
        """Return feedback so that it joins that of the other participant, whichever an operator
        decided on first.
        """
        if action.kind != "feedback":
            return action
        attempt, seat = self._given
        self._given = (action.attempt, action.seat)
        # it would replace the words while the other feedback is awaited
        self.cancel_timer("filler")
        return replace(action, joins=attempt == action.attempt and seat not in ("", action.seat))

    @property
    def _is_idle(self) -> bool:
        """True if nothing waits or is under way."""
        return self._queue.is_idle and not self._approvals.waiting

    def _parts(self, utterance: Utterance) -> list[Part]:
        """Return the parts of an action, by output."""
        wanted = {part for part, field in _FIELDS.items() if getattr(utterance, field)}
        return [
            (opened.output, part)
            for opened in self._outputs
            for part in opened.can
            if part in wanted
        ]

    def _publish_state(self) -> None:
        """Publish whether the agent acts, and the state for operators, if they changed."""
        awaits_operator = self._approvals.is_operator_awaited
        acting = self._queue.is_acting
        if (acting, awaits_operator) != (self._acting.acting, self._acting.awaits_operator):
            self._acting = m.AgentActing(acting=acting, awaits_operator=awaits_operator)
            self.emit(ACTING, self._acting)
        if not self._has_operators:
            return
        state = m.ArbiterState(
            modes=self._approvals.rules.modes,
            operated=self._approvals.rules.operated,
            pending=self._approvals.waiting,
            queued=self._queue.waiting,
            current=self._queue.current,
        )
        if state != self._state:
            self._state = state
            self.emit(ARBITER_STATE, state)

    def _drop(
        self, reason: str, what: Callable[[Utterance], bool] = lambda _: True, actor: str = "agent"
    ) -> None:
        for action in self._queue.remove(what):
            self._emit_dropped(action, reason, _who(reason, actor))
        self._approvals.drop(what, reason, _who(reason, actor))

    def _emit_dropped(self, action: Action, reason: str, actor: str) -> None:
        self.emit(DROPPED, Dropped(id=action.id, reason=reason, actor=actor))  # type: ignore[arg-type]
        outcome: m.ActOutcome = "late" if reason == "late" else "refused"
        self._open_acts.give_up(action.id, outcome, _DROPPED_BECAUSE.get(reason, ""))


_FIELDS: dict[ActionPart, str] = {
    "say": "spoken",
    "show": "text",
    "gesture": "gesture",
    "gaze": "gaze",
    "tone": "tone",
}
"""Field of an utterance that each part uses."""


def _who(reason: str, actor: str) -> str:
    """Return the actor of a drop: operators by name, the participant's own stop key as the
    agent.
    """
    return actor if reason == "stopped" and actor != "participant" else "agent"

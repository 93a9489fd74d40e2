"""The Event Handler: feeds the session's script (thesis 3.2.3)."""

from collections.abc import Callable, Collection
from typing import Any

from sar_tui.loop import marks
from sar_tui.loop.answers import answer_to
from sar_tui.loop.bus import FAULT
from sar_tui.loop.marks import TrialMark
from sar_tui.loop.node import TimedNode, on
from sar_tui.loop.nodes import VITAL
from sar_tui.loop.script import (
    READING,
    Decided,
    End,
    Pause,
    Repeat,
    Resume,
    Script,
    SessionScript,
    Skip,
    SkipAttempt,
    TakeBack,
    TimeUp,
    Withdrawn,
)
from sar_tui.loop.session_phase import (
    IN_TRIAL,
    OVER,
    REQUEST_KEY,
    REQUESTABLE,
    VISIT_ASKED,
    Phase,
    text_of,
)
from sar_tui.loop.task import Task
from sar_tui.loop.topics import (
    ACTING,
    ANSWERED,
    ATTEMPT_ENDED,
    ATTEMPT_STARTED,
    COMMAND,
    CUE,
    FEEDBACK,
    FOCUS,
    FRAME,
    GOAL,
    LEVEL,
    LEVEL_DECIDED,
    LEVEL_REQUEST,
    MARKED,
    NOTE_ADDED,
    PASTE,
    PERCEIVED,
    PROMPT,
    REACH,
    SENSOR,
    SESSION,
    SESSION_ENDED,
    SETTING,
    SHOWN,
    STEP_ENDED,
    STORAGE,
    STORED,
    TAKEN_BACK,
    TIMER,
    TONE_BEGAN,
    TONE_DUE,
    TONES_AHEAD,
    TRIAL,
    TRIAL_FEEDBACK,
    TRIAL_FEEDBACK_SHOWN,
    TYPED,
    UNREADABLE,
    UNSAID_FEEDBACK,
    VISIT,
    VISIT_DECIDED,
    VOIDED,
    WAITING,
)
from sar_tui.loop.trial import OpenTrial
from sar_tui.loop.undo import Done
from sar_tui.model import messages as m
from sar_tui.model.units import SECOND
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.limits import Dose

_Result = tuple[m.ActOutcome, str]
"""Outcome of a command, and why."""
_DONE: _Result = ("done", "")
_OVER: _Result = ("late", "The session is over.")
_NO_PROMPT: _Result = ("late", "No prompt is shown.")
_NO_DISK: _Result = ("refused", "The session cannot write to the disk.")
_KEPT = (Phase.INSTRUCTIONS, Phase.REVIEW, Phase.ENDED)
"""Phases that another run shows again, without a pause."""


class EventHandler(TimedNode):
    """Gives the session's script what it waits for, and interrupts it.

    What does not change the order of a session is done here at once: marks, levels, settings, and
    flags of the open trial.
    """

    name = "event_handler"
    emits = (
        TIMER,
        WAITING,
        ATTEMPT_STARTED,
        CUE,
        PROMPT,
        TONES_AHEAD,
        TONE_DUE,
        FRAME,
        TYPED,
        VOIDED,
        TRIAL,
        TRIAL_FEEDBACK,
        MARKED,
        ATTEMPT_ENDED,
        LEVEL,
        GOAL,
        FEEDBACK,
        TAKEN_BACK,
        STEP_ENDED,
        SESSION_ENDED,
        ANSWERED,
        VISIT_DECIDED,
    )
    asks = (LEVEL_REQUEST, UNSAID_FEEDBACK)

    def __init__(self, task: Task, seed: int, vital: Collection[str] = VITAL) -> None:
        super().__init__()
        self.task = task
        self.vital = vital
        self.session = SessionScript(self, task, seed)
        self.status = self.session.status
        self._script: Script[None] | None = self.session.session()
        self._awaited: tuple[type, ...] = ()

    @property
    def open_trial(self) -> OpenTrial | None:
        """The trial under way, if there is one."""
        return self.session.presenter.trial if self.status.phase in IN_TRIAL else None

    @property
    def trial_mark(self) -> TrialMark:
        """The trial that a mark is put on now, and the mark that is on it."""
        return self.session.scores.trial_mark(self.open_trial)

    # --- the script

    def _hear(self, event: Any) -> None:
        """Give the script an event, if it waits for such."""
        if self._script and isinstance(event, self._awaited):
            script = self._script
            self._run(lambda: script.send(event))

    def _interrupt(self, interruption: Exception) -> None:
        """Interrupt the script where it waits."""
        if script := self._script:
            self._run(lambda: script.throw(interruption))

    def _run(self, step: Callable[[], tuple[type, ...]]) -> None:
        """Let the script run until it waits again."""
        script, self._script = self._script, None  # it is over if it ends or fails
        try:
            self._awaited = step()
        except StopIteration:
            return
        self._script = script
        self._ask_for_visit()

    def _ask_for_visit(self) -> None:
        """Ask the participant whether somebody may watch, if this is a moment for it."""
        if self._script and self.status.must_ask:
            self._interrupt(Pause(VISIT_ASKED))

    def _end_result(self) -> None:
        """Go on at once if the answer to a trial is shown: that trial is over."""
        if self.status.phase is Phase.RESULT:
            self._hear(TimeUp("result", 0))

    # --- runs of the program

    @on(SESSION)
    def session_started(self, session: m.SessionStarted) -> None:
        """Begin the session, or a later run: continue it where the last run stopped."""
        # raises here, where it ends the session, not on the screen
        text_of(self.task.instructions(), "instructions")
        script, status = self.session, self.status
        self.cancel_timers()
        script.undo.clear()
        status.begin_run()
        script.steps.given = session.steps or script.steps.given
        script.dose.begin_run(Dose.of(session.done_today), self.now)
        script.feedback_due_at = 0
        # the clock of the last run says nothing about the time between the runs
        if status.is_resting:
            script.rest_until = self.now + self.task.parameters.rest_seconds * SECOND
        if not self._awaited and self._script:
            self._run(self._script.__next__)
        elif status.phase is Phase.CLOSING:
            self._hear(session)
        elif status.is_paused_by_person or status.phase in _KEPT:
            script.announce(status.phase)
        else:
            self._pause("interrupted")

    @on(FAULT)
    def fault(self, fault: m.Fault) -> None:
        """Stop the session if a vital node failed: nothing can be scored any more."""
        if fault.node in self.vital:
            self.cancel_timers()
            if self.status.phase in IN_TRIAL:
                self.session.void("fault")
            self._script = None
            self.session.announce(Phase.BROKEN)

    # --- what the script waits for

    def timer(self, name: str, late: int) -> None:
        self._hear(TimeUp(name, late))

    @on(PERCEIVED)
    def perceived(self, percept: m.KeyPerceived) -> None:
        """Give the script a key, if that was pressed for what is on the screen."""
        phase, keys = self.status.phase, self.status.keys
        keys.press(percept)
        if phase not in IN_TRIAL and not keys.is_meant(phase):
            return
        if phase in REQUESTABLE and percept.key == REQUEST_KEY:
            self._request_feedback()
        else:
            self._hear(percept)

    @on(REACH)
    def reach_perceived(self, percept: m.ReachPerceived) -> None:
        self._hear(percept)

    @on(SHOWN)
    def shown(self, shown: m.Shown) -> None:
        self._hear(shown)

    @on(TRIAL_FEEDBACK_SHOWN)
    def trial_feedback_shown(self, shown: m.TrialFeedbackShown) -> None:
        self._hear(shown)

    @on(STORED)
    def stored(self, stored: m.Stored) -> None:
        self.status.stored = (stored.attempt, stored.trial)
        self._hear(stored)

    @on(ACTING)
    def agent_acted(self, agent: m.AgentActing) -> None:
        was_awaited = self.status.awaits_operator
        self.status.is_agent_acting = agent.acting
        self.status.awaits_operator = agent.awaits_operator
        self._hear(agent)
        if was_awaited and not agent.awaits_operator:
            self._hear(Decided())
        self._ask_for_visit()

    @on(PASTE)
    def pasted(self, paste: m.Pasted) -> None:
        self.status.keys.last = paste.at
        self._flag("paste")
        self._hear(paste)

    # --- the open trial

    @on(TONE_BEGAN)
    def tone_began(self, began: m.ToneBegan) -> None:
        if self.status.phase in (Phase.ONSET, Phase.RESPONSE):
            self.session.presenter.trial.tone_began(began)

    @on(UNREADABLE)
    def input_dropped(self, dropped: m.InputDropped) -> None:
        self._flag("unreadable_input")

    @on(FOCUS)
    def focus_changed(self, focus: m.FocusChanged) -> None:
        self.status.focused = focus.focused
        if not focus.focused:
            self._flag("focus_lost")

    def _flag(self, flag: str) -> None:
        if trial := self.open_trial:
            trial.flag(flag)

    # --- interruptions

    def _pause(self, reason: str) -> None:
        self._end_result()
        self._interrupt(Pause(reason))

    @on(STORAGE)
    def storage_changed(self, storage: m.StorageChanged) -> None:
        """Pause when writing to disk fails, or goes on elsewhere; show when it works again."""
        phase, blockers = self.status.phase, self.status.blockers
        blockers.update_storage(storage)
        goes_on_elsewhere = storage.working and bool(storage.reason)
        if phase is Phase.CLOSING or (phase is Phase.PAUSED and not goes_on_elsewhere):
            self.session.announce(phase)
        elif (blockers.has_disk_failed or goes_on_elsewhere) and phase not in OVER:
            self._pause("restored")  # shown as "storage" until writing works again

    @on(SENSOR)
    def sensor_changed(self, sensor: m.SensorChanged) -> None:
        """Pause when a sensor sends no data; the script resumes when it does again."""
        status = self.status
        if status.phase in OVER or not status.blockers.update_sensor(sensor):
            return
        if status.blockers.is_sensor_lost:
            self._end_result()
        if status.phase is Phase.PAUSED:
            self._hear(sensor)
        elif status.blockers.is_sensor_lost and self.session.needs_sensor:
            self._interrupt(Pause("sensor"))

    @on(VISIT)
    def visit_requested(self, request: m.VisitRequested) -> None:
        """Note who asks to watch; the participant is asked as soon as there is a moment for it."""
        asking = self.status.asking
        if request.state == "withdrawn":
            if request.actor in asking:
                asking.remove(request.actor)
                self._hear(Withdrawn())
        elif not self.status.are_visits_over and self.status.phase not in OVER:
            asking.append(request.actor)
            self._ask_for_visit()

    def _end_visit(self, actor: str) -> _Result:
        """Decline or end a visit, on behalf of the participant."""
        if actor != "participant":
            return "refused", "Only the participant can end a visit."
        is_asked = self.status.reason == VISIT_ASKED
        self.session.decide_visit("declined" if is_asked else "ended")
        if is_asked:
            self._hear(Withdrawn())
        return _DONE

    @on(COMMAND)
    def command_received(self, act: m.SessionCommand) -> None:
        """Carry out a command, and answer it. The arbiter stops the agent."""
        if act.command != "stop":
            self._answer(act, *self._carry_out(act))

    def _carry_out(self, act: m.SessionCommand) -> _Result:  # noqa: PLR0911
        """Carry out a command. Return what became of it, and why."""
        if self.status.phase in OVER:
            return _OVER
        if self.status.blockers.has_disk_failed and act.command in ("pause", "resume"):
            return _NO_DISK
        match act.command:
            case "pause":
                self._pause(act.reason)
            case "resume":
                return self._resume()
            case "end":
                self._end_result()
                self._interrupt(End("ended"))
            case "repeat":
                return self._repeat()
            case "skip":
                return self._skip(act.reason, act.value)
            case "level":
                self._set_level(act)
            case "hold" | "release":
                self._hold_level(act)
            case "mark":
                return self._mark(act)
            case "undo":
                return self._undo(act.actor)
            case "dismiss":
                return self._end_visit(act.actor)
        return _DONE

    def _resume(self) -> _Result:
        if self.status.phase is not Phase.PAUSED:
            return "late", "The session is not paused."
        if self.status.reason == VISIT_ASKED:
            return "refused", "The participant is asked whether somebody may watch."
        self._hear(Resume())
        if self.status.phase is Phase.PAUSED:
            return "refused", "The sensor sends no data."
        return _DONE

    def _repeat(self) -> _Result:
        if self.status.phase not in IN_TRIAL:
            return _NO_PROMPT
        self._interrupt(Repeat("repeat"))
        return _DONE

    def _skip(self, what: str, number: int | None) -> _Result:
        """End the prompt as missed, a step between attempts or a rest; or leave out an ``attempt``.

        An operator's key may come when the participant has just answered: a ``step`` is ended by
        its ``number`` only.
        """
        phase, asked = self.status.phase, self.session.steps.asked
        if what == "attempt":
            return self._skip_attempt()
        if what == "step" and (asked is None or asked.number != number):
            return "late", "The participant has just answered."
        if phase is Phase.STEP and (asked is None or asked.step.required):
            return "refused", "Nobody else can answer that."
        if phase is Phase.PAUSED and self.status.is_resting:
            self.session.rest_until = self.now
        elif phase in (Phase.REST, Phase.STEP, *IN_TRIAL):
            self._interrupt(Skip())
        else:
            return _NO_PROMPT
        return _DONE

    def _skip_attempt(self) -> _Result:
        if not self.status.can_skip_attempt:
            return "late", "The attempt is over."
        if self.status.blockers.has_disk_failed:
            return _NO_DISK
        self._interrupt(SkipAttempt("skipped"))
        return _DONE

    # --- what does not change the order of a session

    def _announce_again(self, *phases: Phase) -> None:
        """Say again what the session waits for, if it is in one of these phases."""
        if self.status.phase in phases:
            self.session.announce(self.status.phase)

    def _request_feedback(self) -> None:
        if self.session.scores.request_feedback():
            if self.has_timer("continue"):
                self.session.continue_after(READING)
            self.session.announce(self.status.phase)

    def _mark(self, act: m.SessionCommand) -> _Result:
        """Put a mark on the current trial, else the last one, or take it off."""
        name, before = act.reason, self.trial_mark
        if marks.find(self.task.marks, name) is None:
            return "refused", "There is no such mark in this task."
        self._put_mark(name)
        if self.trial_mark == before:
            return "refused", "There is no trial to mark."
        self._can_undo(
            act,
            "mark",
            lambda: self._put_mark(before.present or name),
            is_possible=lambda: self.trial_mark.trial == before.trial,
        )
        return "done", "removed" if before.present == name else ""

    def _put_mark(self, name: str) -> None:
        mark = marks.find(self.task.marks, name)
        if mark and self.session.scores.mark(mark, self.open_trial):
            self.session.announce(self.status.phase)

    def _set_level(self, act: m.SessionCommand) -> None:
        scores, before = self.session.scores, self.session.attempts.state
        scores.set_level(self.session.attempts.level if act.value is None else act.value)
        self._can_undo(act, "level", lambda: scores.restore_level(before))
        self._announce_again(Phase.READY)

    def _hold_level(self, act: m.SessionCommand) -> None:
        attempts = self.session.attempts
        was_held = attempts.next.is_level_held
        attempts.hold_level(held=act.command == "hold")
        self._can_undo(act, "hold", lambda: attempts.hold_level(held=was_held))

    @on(LEVEL_DECIDED)
    def level_decided(self, decided: m.LevelDecided) -> None:
        """Apply a change of level that waited for an operator; a rejected one changes nothing."""
        if decided.decision != "rejected" and self.status.phase not in OVER:
            self.session.undo.forget("level")
            self.session.scores.settle_level(decided.level)
            self._announce_again(Phase.READY)

    @on(SETTING)
    def setting_changed(self, change: m.SettingChanged) -> None:
        """Change a setting from the next attempt on."""
        if self.status.phase in OVER:
            self._answer(change, *_OVER)
            return
        scores, before = self.session.scores, self.session.attempts.next.settings
        try:
            scores.change_setting(change.name, change.value)
        except ParameterError as error:
            self._answer(change, "refused", str(error))
        else:
            self._can_undo(
                change,
                "setting",
                lambda: scores.change_setting(change.name, before[change.name]),
            )
            self._answer(change)
        self._announce_again(Phase.READY)

    @on(NOTE_ADDED)
    def note_added(self, note: m.NoteAdded) -> None:
        """Let a note be taken back. The arbiter answers it."""
        self._can_undo(note, "note", lambda: None, at=note.at)

    # --- what is taken back

    def undoable(self, actor: str, now: int) -> Done | None:
        """Return the act that a person can take back now (ns); None if there is none."""
        return None if self.status.phase in OVER else self.session.undo.of(actor, now)

    def _can_undo(
        self,
        act: m.OperatorAct,
        what: m.TakenBackKind,
        take_back: Callable[[], object],
        *,
        at: int = 0,
        is_possible: Callable[[], bool] = lambda: True,
    ) -> None:
        """Let an act be taken back by the person who did it."""
        done = Done(act.actor, what, at or self.now, take_back, act=act.id, is_possible=is_possible)
        self.session.undo.note(done)

    def _undo(self, actor: str) -> _Result:
        """Take back what a person did last."""
        done = self.undoable(actor, self.now)
        if done is None:
            return "late", "There is nothing to take back any more."
        self.session.undo.drop(done)
        taken_back = m.TakenBack(
            seat=done.seat,
            what=done.what,
            actor=actor,
            number=done.number,
            act=done.act,
            done=done.at,
        )
        self.emit(TAKEN_BACK, taken_back)
        if done.take_back is None:
            self._interrupt(TakeBack("undo"))
        else:
            done.take_back()
            self._announce_again(Phase.READY)
        return _DONE

    def _answer(self, act: m.OperatorAct, outcome: m.ActOutcome = "done", why: str = "") -> None:
        """Answer an operator's act, if it carries an id."""
        if act.id:
            self.emit(ANSWERED, answer_to(act, self.now, outcome, why))

"""The Event Handler: runs the session, from the instructions to the last attempt (thesis 3.2.3)."""

from collections.abc import Collection

from msgspec.structs import replace

from sar_tui.loop import marks
from sar_tui.loop.blockers import Blockers
from sar_tui.loop.bus import FAULT
from sar_tui.loop.node import on
from sar_tui.loop.nodes import VITAL
from sar_tui.loop.nodes.step_flow import StepFlow
from sar_tui.loop.session_phase import (
    ENTER_RESUMES,
    IN_TRIAL,
    LEFT,
    OVER,
    PAUSES,
    REQUEST_KEY,
    REQUESTABLE,
    Phase,
    text_of,
    waiting_message,
)
from sar_tui.loop.task import Task
from sar_tui.loop.topics import (
    ANSWERED,
    ATTEMPT_ENDED,
    ATTEMPT_STARTED,
    COMMAND,
    CUE,
    FEEDBACK,
    FRAME,
    GOAL,
    LEVEL,
    LEVEL_REQUEST,
    MARKED,
    PROMPT,
    SENSOR,
    SESSION,
    SESSION_ENDED,
    STEP_ENDED,
    STORAGE,
    STORED,
    TIMER,
    TONE_DUE,
    TONES_AHEAD,
    TRIAL,
    TRIAL_FEEDBACK,
    TYPED,
    UNSAID_FEEDBACK,
    VOIDED,
    WAITING,
)
from sar_tui.model import messages as m
from sar_tui.model.trial_types import Result
from sar_tui.model.units import SECOND
from sar_tui.rules.key_guard import GuardedPress
from sar_tui.rules.limits import Dose

_Result = tuple[m.ActOutcome, str]
"""Outcome of a command, and why."""
_DONE: _Result = ("done", "")
_NO_PROMPT: _Result = ("late", "No prompt is shown.")


class EventHandler(StepFlow):
    """Runs the session: phases, pauses, faults and the end. The base classes run its steps,
    attempts and trials.
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
        STEP_ENDED,
        SESSION_ENDED,
        ANSWERED,
    )

    asks = (LEVEL_REQUEST, UNSAID_FEEDBACK)

    def __init__(self, task: Task, seed: int, vital: Collection[str] = VITAL) -> None:
        super().__init__(task, seed)
        self.vital = vital
        self._pause_reason = ""
        self._blockers = Blockers(task.sensor_seats(task.parameters))
        self._status: m.EndStatus = "completed"
        self._on_screen: object = None
        """The thing that a participant is asked for at present."""

    @property
    def is_recording_over(self) -> bool:
        """True if a recording that replaces a sensor is at its end."""
        return self._blockers.is_recording_over

    # --- the session

    @on(SESSION)
    def session_started(self, session: m.SessionStarted) -> None:
        """Show the instructions in the first run; continue where the last run stopped in a later
        one.
        """
        # raises here, where it ends the session, not on the screen
        text_of(self.task.instructions(), "instructions")
        self._rules = session.rules
        self._given = session.steps or self._given
        self._last_key = None
        self._start_key.release()
        self._key_guard.reset()
        self._on_screen = None
        self._focused = True
        self._is_agent_acting = False
        self._feedback_due_at = 0
        self._is_decision_pending = False
        self.cancel_timers()
        self._stored = self._last_trial
        self._blockers.reset()
        self._count_from_here(Dose.of(session.done_today))
        was_paused_by_person = self._phase is Phase.PAUSED and self._pause_reason not in (
            *PAUSES,
            LEFT,
        )
        keeps_phase = was_paused_by_person or self._phase in (
            Phase.INSTRUCTIONS,
            Phase.REVIEW,
            Phase.ENDED,
        )
        # the clock of the last run says nothing about the time between the runs
        if self.is_resting:
            self._rest_until = self.now + self.task.parameters.rest_seconds * SECOND
        if self._phase is Phase.CLOSING:
            self._end()
        elif session.run == 1 or keeps_phase:
            self._wait(self._phase)
        else:
            self._pause("interrupted")

    @on(FAULT)
    def fault(self, fault: m.Fault) -> None:
        """Stop the session if a vital node failed: nothing can be scored any more."""
        if fault.node in self.vital:
            self._void("fault")
            self._wait(Phase.BROKEN)

    @on(COMMAND)
    def command_received(self, act: m.SessionCommand) -> None:
        """Carry out a command, and answer it. The arbiter stops the agent."""
        if act.command != "stop":
            self._answer(act, *self._carry_out(act))

    def _carry_out(self, act: m.SessionCommand) -> _Result:  # noqa: PLR0911
        """Carry out a command. Return what became of it, and why."""
        if self._phase in OVER:
            return "late", "The session is over."
        if self._blockers.has_disk_failed and act.command in ("pause", "resume"):
            return "refused", "The session cannot write to the disk."
        match act.command:
            case "pause":
                self._pause(act.reason)
            case "resume":
                if self._phase is not Phase.PAUSED:
                    return "late", "The session is not paused."
                self._resume()
                if self._phase is Phase.PAUSED:
                    return "refused", "The sensor sends no data."
            case "end":
                self._end_result()
                self._void("ended")
                self._close_early()
            case "level":
                self._set_level(act.value if act.value is not None else self._attempts.level)
            case "hold" | "release":
                self._attempts.hold_level(held=act.command == "hold")
            case "repeat":
                return self._repeat()
            case "skip":
                return self._skip(act.reason, act.value)
            case "mark":
                return self._set_mark(act.reason)
        return _DONE

    def _repeat(self) -> _Result:
        """Show the prompt again."""
        if self._phase not in IN_TRIAL:
            return _NO_PROMPT
        self._void("repeat")
        self._go_on()
        return _DONE

    def _skip(self, what: str, number: int | None) -> _Result:  # noqa: PLR0911
        """End the prompt as missed, a step between attempts or a rest; or leave out an ``attempt``.

        An operator's key may come when the participant has just answered: a ``step`` is ended by
        its ``number`` only.
        """
        if what == "attempt":
            return self._skip_attempt()
        if what == "step" and (self._asked is None or self._asked.number != number):
            return "late", "The participant has just answered."
        if self.is_resting:
            self._end_rest()
            return _DONE
        if self._phase is Phase.STEP:
            if self._asked is None or self._asked.step.required:
                return "refused", "Nobody else can answer that."
            self._end_step("skipped", None, self.now)
            return _DONE
        if self._phase in IN_TRIAL:
            self._finish(Result(correct=False, flags=("skipped",)))
            return _DONE
        return _NO_PROMPT

    def _set_mark(self, name: str) -> _Result:
        """Put a mark on the current trial, else the last one, or take it off."""
        mark = marks.find(self.task.marks, name)
        if mark is None:
            return "refused", "There is no such mark in this task."
        before = self.trial_mark
        self._mark(mark)
        if self.trial_mark == before:
            return "refused", "There is no trial to mark."
        return "done", "removed" if before.present == name else ""

    @property
    def can_skip_attempt(self) -> bool:
        """True if an attempt is under way, or waits to be begun."""
        from_phase = self._paused_from if self._phase is Phase.PAUSED else self._phase
        return self._is_under_way or from_phase is Phase.READY

    def _skip_attempt(self) -> _Result:
        """Leave out the attempt that is under way or comes next. What was done of it stays; nothing
        is scored.
        """
        if not self.can_skip_attempt:
            return "late", "The attempt is over."
        if self._blockers.has_disk_failed:
            return "refused", "The session cannot write to the disk."
        self._void("skipped")
        goes_on = self._attempts.skip()
        self._phase, self._paused_from = Phase.PAUSED, Phase.READY if goes_on else Phase.REVIEW
        self._resume()
        return _DONE

    @on(STORAGE)
    def storage_changed(self, storage: m.StorageChanged) -> None:
        """Pause the session when writing to disk fails, or goes on elsewhere; let it be resumed
        when it works.
        """
        self._blockers.update_storage(storage)
        goes_on_elsewhere = storage.working and bool(storage.reason)
        if self._phase is Phase.CLOSING or (self._phase is Phase.PAUSED and not goes_on_elsewhere):
            self._wait(self._phase)
        elif (self._blockers.has_disk_failed or goes_on_elsewhere) and self._phase not in OVER:
            self._pause("restored")  # shown as "storage" until writing works again

    @on(SENSOR)
    def sensor_changed(self, sensor: m.SensorChanged) -> None:
        """Pause the session when a sensor sends no data, and resume it when it does again."""
        if self._phase in OVER or not self._blockers.update_sensor(sensor):
            return
        if lost := self._blockers.is_sensor_lost:
            self._end_result()
        waits_for_sensor = self._phase is Phase.PAUSED and self._pause_reason == "sensor"
        if lost and self._phase is not Phase.PAUSED and self._needs_sensor(self._phase):
            self._pause("sensor")
        elif lost and waits_for_sensor:
            self._wait(Phase.PAUSED)
        elif waits_for_sensor and self._blockers.has_disk_failed:
            self._pause("restored")
        elif waits_for_sensor:
            self._resume()

    @on(STORED)
    def stored(self, stored: m.Stored) -> None:
        super().stored(stored)
        if self._phase is Phase.CLOSING and self._stored == self._last_trial:
            self._end()

    def _pause(self, reason: str) -> None:
        if self._phase is not Phase.PAUSED:
            self._end_result()
            self._paused_from = self._phase
            self._void(reason or "pause")
        self._pause_reason = reason
        self._wait(Phase.PAUSED)

    def _resume(self) -> None:
        if self._blockers.is_sensor_lost and self._needs_sensor(self._paused_from):
            self._pause("sensor")
        elif self._is_under_way:
            self._last_key = self.now
            self._go_on()
        elif self._paused_from is Phase.FEEDBACK:
            self._await_feedback()
        elif self._paused_from is Phase.REST:
            self._rest(self._rest_until)
        elif self._paused_from is Phase.STEP:
            self._show_step()
        else:
            self._wait(self._paused_from)
            self._wait_for_decision()

    def _go_on(self) -> None:
        """Go on with the attempt, or wait for Enter to begin it again if its trials build on each
        other.
        """
        if self.task.restarts_attempts and self._attempts.trial > 1:
            self._attempts.restart()
            self._is_restarted = True
            self._wait(Phase.READY)
            self._wait_for_decision()
        else:
            super()._go_on()

    def timer(self, name: str, late: int) -> None:
        """Begin the next attempt of a continuous task."""
        if name != "continue":
            super().timer(name, late)
        elif self._phase is Phase.READY:
            self._begin_attempt_or_end()

    def _needs_sensor(self, phase: Phase) -> bool:
        """Return True if movements follow: not in the instructions, and not after the last
        attempt.
        """
        return not (self._is_all_done_in(phase) or phase is Phase.INSTRUCTIONS)

    def _is_all_done_in(self, phase: Phase) -> bool:
        """Return True if the last attempt has ended."""
        is_between = phase in (Phase.FEEDBACK, Phase.STEP)
        return phase is Phase.REVIEW or (is_between and self._after_feedback is Phase.REVIEW)

    def _close(self, status: m.EndStatus) -> None:
        """End the session as soon as its last trial is on disk."""
        self._status = status
        if self._stored == self._last_trial:
            self._end()
        else:
            self._wait(Phase.CLOSING)

    def _close_early(self) -> None:
        """End the session at an operator's or participant's command; without agreement nothing else
        of it is kept.
        """
        from_phase = self._paused_from if self._phase is Phase.PAUSED else self._phase
        if self.awaits_agreement:
            self._refuse()
        else:
            self._close("completed" if self._is_all_done_in(from_phase) else "aborted")

    def _refuse(self) -> None:
        self._close("refused")

    def _end(self) -> None:
        self._wait(Phase.ENDED)
        self.emit(SESSION_ENDED, m.SessionEnded(status=self._status))

    def _key_between_trials(self, percept: m.KeyPerceived, press: GuardedPress) -> None:
        """Handle a key, unless it was pressed for something that is not on the screen any more."""
        is_new = press.after_quiet if self._phase is Phase.READY else press.is_new
        if self._rules < 6 or (press.counts and (is_new or percept.key != "enter")):
            self._take_key(percept)

    def _take_key(self, percept: m.KeyPerceived) -> None:
        match self._phase, percept.key:
            case Phase.INSTRUCTIONS, "enter":
                if self._is_step_due():
                    self._ask()
                else:
                    self._await_first_attempt()
            case Phase.STEP, _:
                self._key_in_step(percept)
            case Phase.READY, "enter" if not percept.repeat:
                self._begin_attempt_or_end()
            case Phase.REVIEW, "enter" if not percept.repeat:
                self._close("completed")
            case phase, key if phase in REQUESTABLE and key == REQUEST_KEY:
                self._request_feedback()
            case Phase.PAUSED, "enter" if self._reason in ENTER_RESUMES:
                self._resume()

    def _await_first_attempt(self) -> None:
        super()._await_first_attempt()
        if self._blockers.is_sensor_lost:
            self._pause("sensor")

    def _begin_attempt_or_end(self) -> None:
        """Begin the attempt, unless a limit was reached while the participant rested."""
        self._limit = self._limit_text
        if self._limit:
            self._wait(Phase.REVIEW)
        else:
            self._begin_attempt()

    # --- waiting

    @property
    def _reason(self) -> str:
        """Reason of the pause: a disk failure takes precedence over what a person gave."""
        if self._blockers.has_disk_failed and self._phase in (Phase.PAUSED, Phase.CLOSING):
            return "storage"
        return self._pause_reason if self._phase is Phase.PAUSED else ""

    def _wait(self, phase: Phase, reason: str = "") -> None:
        self._phase = phase
        why = reason or self._reason
        self._note_appearance(why)
        notice = self._notice_for(phase)
        detail = self._blockers.detail(why)
        seat = self._blockers.lost_seat if why == "sensor" else self._turn
        message = waiting_message(
            phase,
            self._attempts,
            self.task,
            notice=notice,
            reason=why,
            detail=detail,
            seat=seat,
            until=self._ends_at(phase),
        )
        changed = self._why_changed if phase is Phase.READY else ""
        if phase is Phase.STEP:
            message = replace(message, step=self._asked)
        self.emit(WAITING, replace(message, why=changed) if changed else message)

    def _note_appearance(self, why: str) -> None:
        """Note when something else is asked for than before. What is asked again in other words
        stays the same.
        """
        asked = (
            (self._asked.number, self._asked.shown)
            if self._phase is Phase.STEP and self._asked
            else None
        )
        on_screen = (self._phase, self._attempts.attempt, asked, why)
        if on_screen != self._on_screen:
            self._on_screen = on_screen
            self._key_guard.appeared(self.now)

    def _ends_at(self, phase: Phase) -> int:
        """Return when a wait ends by itself (ns); 0 if that is not known."""
        if phase is Phase.REST:
            return self._rest_until
        if phase is Phase.STEP:
            return self._step_until
        return self._continues_at if phase is Phase.READY and self.has_timer("continue") else 0

    @property
    def _turn(self) -> str:
        """The seat whose turn it is, if it may be known; empty for all seats."""
        if len(self.task.seats) == 1:
            return self.task.seats[0]
        return self._trial.turn if self._phase in IN_TRIAL else ""

    def _notice_for(self, phase: Phase) -> str:
        """Return what the participant must know first.

        That practice is over, a new level, a trial to repeat, or a limit that is reached.
        """
        if phase is Phase.READY:
            counts = self.task.tr("Practice is over. From here on it counts.")
            again = self.task.tr("This attempt begins again.") if self._is_restarted else ""
            parts = [
                again,
                counts if self._attempts.is_first_after_practice else "",
                self._level_notice,
            ]
            return " ".join(filter(None, parts))
        if phase is Phase.REVIEW:
            return self._limit
        return self._notice if phase is Phase.START else ""

    @property
    def _level_notice(self) -> str:
        """Notice of a level that differs from the last attempt's; empty for none."""
        if self._attempts.level == self._announced_level:
            return ""
        return text_of(self.task.notice(self._attempts.level, self._announced_level), "notice")

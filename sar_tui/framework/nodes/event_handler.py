"""The Event Handler: runs the task, from the first Enter to the last attempt (thesis 3.2.3)."""

from collections.abc import Collection
from typing import Literal

import msgspec

from sar_tui.framework import messages as m
from sar_tui.framework.bus import FAULT
from sar_tui.framework.clock import MS, SECOND
from sar_tui.framework.course import Course
from sar_tui.framework.node import STALLED, TimedNode, on
from sar_tui.framework.nodes import VITAL
from sar_tui.framework.obstacles import Obstacles
from sar_tui.framework.phase import BEFORE_PROMPT, ENTER_GOES_ON, IN_TRIAL, MARKABLE, OVER, PAUSES, Phase
from sar_tui.framework.task import Again, Mark, Result, Task
from sar_tui.framework.topics import (
    ATTEMPT_ENDED,
    ATTEMPT_STARTED,
    FEEDBACK,
    FOCUS,
    LEVEL,
    MARKED,
    OPERATOR,
    PASTE,
    PERCEIVED,
    PROMPT,
    REACH,
    SENSOR,
    SESSION,
    SESSION_ENDED,
    SHOWN,
    STORAGE,
    STORED,
    TIMER,
    TRIAL,
    VOIDED,
    WAITING,
)
from sar_tui.framework.trial import OpenTrial
from sar_tui.framework.waiting import waiting

GRACE = 50 * MS
"""A response stamped in time may be handled this much after the time-out was, however late that itself came."""
MOST_AGAIN = 3
"""After so many times of which nothing can be said a trial counts as missed: nobody is asked without end."""
HELD_KEY = 700 * MS
"""The key that starts a trial, so soon after itself, is held: keyboards repeat first after 250 to 660 ms."""
HELD = 3 * SECOND
"""After this long without quiet the participant is asked to let go of the keys."""
_WITHOUT_SENSOR = (Phase.INSTRUCTIONS, Phase.REVIEW)
"""Where no movement is about to be made, and so no sensor is needed."""


class EventHandler(TimedNode):
    """Attempts and prompts: what comes when. The course scores and adapts, the open trial keeps what was seen.

    A trial runs (start) → quiet → foreperiod → (storing) → onset → response; a key in the foreperiod begins it anew;
    a pause, a sensor that comes loose, or the end of the program, voids it, and it is repeated under the same number
    with the same prompt.
    """

    name = "event_handler"
    emits = (
        TIMER,
        WAITING,
        ATTEMPT_STARTED,
        PROMPT,
        VOIDED,
        TRIAL,
        MARKED,
        ATTEMPT_ENDED,
        LEVEL,
        FEEDBACK,
        SESSION_ENDED,
    )

    def __init__(self, task: Task, seed: int, vital: Collection[str] = VITAL) -> None:
        super().__init__()
        self.task = task
        self.vital = vital
        self.parameters = task.parameters
        self._phase = Phase.INSTRUCTIONS
        self._course = Course(task, seed)
        self._focused = True
        self._trial: OpenTrial
        self._stored = (0, 0)
        self._last_trial = (0, 0)
        self._unmarked: Result
        self._marked: Mark | None = None
        self._agains = 0
        self._last_key: int | None = None
        self._start_key_at: int | None = None
        self._restless_since = 0
        self._paused_from = Phase.INSTRUCTIONS
        self._pause_reason = ""
        self._obstacles = Obstacles(needs_sensor=bool(task.sensors))
        self._notice = ""
        self._told_level = 0
        self._status: Literal["completed", "aborted"] = "completed"

    # --- the session -------------------------------------------------------------------------------------

    @on(SESSION)
    def session_started(self, session: m.SessionStarted) -> None:
        """The first run shows the instructions; a later one goes on where the last was cut off."""
        self._last_key = None
        self._start_key_at = None
        self._focused = True
        self.cancel_timers()
        self._stored = self._last_trial
        self._obstacles.begin_run()
        was_menu = self._phase is Phase.PAUSED and self._pause_reason not in PAUSES
        if self._phase is Phase.CLOSING:
            self._end()
        elif session.run == 1 or was_menu or self._phase in (Phase.INSTRUCTIONS, Phase.REVIEW, Phase.ENDED):
            self._wait(self._phase)
        else:
            self._pause("interrupted")

    @on(FAULT)
    def fault(self, fault: m.Fault) -> None:
        """Without one of the vital nodes nothing can be judged any more: stop here, whatever comes."""
        if fault.node in self.vital:
            self._void("fault")
            self._wait(Phase.BROKEN)

    @on(OPERATOR)
    def operator_acted(self, act: m.Operator) -> None:
        if self._phase in OVER:
            return
        match act.command:
            case "pause":
                if not self._obstacles.disk_refuses:
                    self._pause(act.reason)
            case "resume":
                if self._phase is Phase.PAUSED and not self._obstacles.disk_refuses:
                    self._resume()
            case "end":
                self._void("ended")
                self._close("aborted")
            case "level":
                self._set_level(act.value if act.value is not None else self._course.level)
            case "repeat" if self._phase in IN_TRIAL:
                self._void("repeat")
                self._begin_trial()
            case "skip" if self._phase in IN_TRIAL:
                self._finish(Result(correct=False, flags=("skipped",)))
            case "mark":
                for mark in self.task.marks:
                    if mark.name == act.reason:
                        self._mark(mark)

    @on(STORAGE)
    def storage_changed(self, storage: m.StorageChanged) -> None:
        """A disk that refuses pauses the session; one that writes again lets it go on."""
        self._obstacles.hear_storage(storage)
        if self._phase in (Phase.CLOSING, Phase.PAUSED):
            self._wait(self._phase)
        elif self._obstacles.disk_refuses and self._phase not in OVER:
            self._pause("restored")

    @on(SENSOR)
    def sensor_changed(self, sensor: m.SensorChanged) -> None:
        """A sensor from which nothing comes stops the session; when it comes again, the session goes on."""
        if self._phase in OVER or not self._obstacles.hear_sensor(sensor):
            return
        lost = self._obstacles.sensor_lost
        waits_for_sensor = self._phase is Phase.PAUSED and self._pause_reason == "sensor"
        if lost and self._phase not in (Phase.PAUSED, *_WITHOUT_SENSOR):
            self._pause("sensor")
        elif lost and waits_for_sensor:
            self._wait(Phase.PAUSED)
        elif waits_for_sensor and self._obstacles.disk_refuses:
            self._pause("restored")
        elif waits_for_sensor:
            self._resume()

    @on(STORED)
    def stored(self, stored: m.Stored) -> None:
        self._stored = (stored.attempt, stored.trial)
        if self._phase is Phase.STORING and self._stored == self._last_trial:
            self._show()
        elif self._phase is Phase.CLOSING and self._stored == self._last_trial:
            self._end()

    def _pause(self, reason: str) -> None:
        if self._phase is not Phase.PAUSED:
            self._paused_from = self._phase
            self._void(reason or "pause")
        self._pause_reason = reason
        self._wait(Phase.PAUSED)

    def _resume(self) -> None:
        if self._obstacles.sensor_lost and self._paused_from not in _WITHOUT_SENSOR:
            self._pause("sensor")
        elif self._is_under_way:
            self._last_key = self.now
            self._begin_trial()
        else:
            self._wait(self._paused_from)

    def _close(self, status: Literal["completed", "aborted"]) -> None:
        """End the session, once its last trial is on the disk."""
        self._status = status
        if self._stored == self._last_trial:
            self._end()
        else:
            self._wait(Phase.CLOSING)

    def _end(self) -> None:
        self._wait(Phase.ENDED)
        self.emit(SESSION_ENDED, m.SessionEnded(status=self._status))

    # --- attempts -----------------------------------------------------------------------------------------

    @property
    def _is_under_way(self) -> bool:
        """Whether an attempt has begun, and not ended."""
        return (self._paused_from if self._phase is Phase.PAUSED else self._phase) in IN_TRIAL

    def _begin_attempt(self) -> None:
        self.emit(ATTEMPT_STARTED, self._course.begin(self.now))
        self._told_level = self._course.level
        self._trial = self._course.next_trial()
        self._begin_trial()

    def _end_attempt(self) -> None:
        """Score, adapt, answer: in this order, so that memory holds the attempt before it is spoken of."""
        scored = self._course.score(self.now)
        self.emit(ATTEMPT_ENDED, scored.ended)
        if scored.level:
            self.emit(LEVEL, scored.level)
        if scored.feedback:
            self.emit(FEEDBACK, scored.feedback)
        self._wait(Phase.READY if self._course.advance() else Phase.REVIEW)

    def _set_level(self, level: int) -> None:
        if changed := self._course.set_level(level, under_way=self._is_under_way):
            self.emit(LEVEL, changed)
        if self._phase is Phase.READY:
            self._wait(Phase.READY)

    # --- trials --------------------------------------------------------------------------------------------

    def _begin_trial(self, notice: str = "") -> None:
        """Let the participant start the trial, where that is theirs to do; else let it come by itself."""
        self._notice = notice
        if self.task.start_key:
            self._wait(Phase.START)
        else:
            self._lead_up()

    def _start_trial(self, at: int) -> None:
        self._trial.started = at
        self._lead_up()

    def _lead_up(self) -> None:
        if self.task.has_foreperiod:
            self._await_quiet()
        else:
            self._show_when_stored()

    def _show_when_stored(self) -> None:
        if self._stored == self._last_trial:
            self._show()
        else:
            self._wait(Phase.STORING)

    def _await_quiet(self) -> None:
        """Let the foreperiod begin when no key has been pressed for a moment."""
        self._restless_since = self.now
        self._wait(Phase.QUIET)
        self._set_quiet_timer()

    def _set_quiet_timer(self) -> None:
        quiet = self.parameters.quiet_ms * MS
        self.set_timer("quiet", self.now if self._last_key is None else max(self.now, self._last_key + quiet))

    def timer(self, name: str, late: int) -> None:
        match name:
            case "quiet":
                wait = self._trial.draw_foreperiod(self.parameters.foreperiod_min_ms, self.parameters.foreperiod_max_ms)
                self._wait(Phase.FOREPERIOD)
                self.set_timer("foreperiod", self.now + wait)
            case "foreperiod":
                self._show_when_stored()
            case "timeout" if late > STALLED:
                self._void("stalled")
                self._begin_trial()
            case "timeout":
                self._trial.lag = late
                self.set_timer("grace", self.now + GRACE)
            case "grace":
                self._finish(self.task.timed_out(self._trial.view()))

    def _show(self) -> None:
        if not self._focused:
            self._trial.flag("focus_lost")
        self.emit(PROMPT, self._trial.prompt(self.parameters.response_timeout_ms * MS))
        self._wait(Phase.ONSET)

    @on(SHOWN)
    def shown(self, shown: m.Shown) -> None:
        """The prompt is on the screen: judge what was pressed while it was on its way, and wait."""
        if self._phase is not Phase.ONSET or not self._trial.is_shown_by(shown):
            return
        self._phase = Phase.RESPONSE
        self._trial.set_onset(shown)
        self.set_timer("timeout", shown.at + self.parameters.response_timeout_ms * MS)
        for percept in self._trial.early:
            if self._phase is Phase.RESPONSE:
                self._judge(percept)

    @on(PERCEIVED)
    def perceived(self, percept: m.KeyPerceived) -> None:
        self._last_key = percept.at
        self._judge_key(percept)
        if percept.key == self.task.start_key:
            self._start_key_at = percept.at

    def _is_held(self, at: int) -> bool:
        return self._start_key_at is not None and at - self._start_key_at < HELD_KEY

    def _judge_key(self, percept: m.KeyPerceived) -> None:
        match self._phase:
            case Phase.INSTRUCTIONS if percept.key == "enter":
                self._wait(Phase.READY)
                if self._obstacles.sensor_lost:
                    self._pause("sensor")
            case Phase.READY if percept.key == "enter" and not percept.repeat:
                self._begin_attempt()
            case Phase.REVIEW if percept.key == "enter" and not percept.repeat:
                self._close("completed")
            case Phase.PAUSED if percept.key == "enter" and self._reason in ENTER_GOES_ON:
                self._resume()
            case Phase.START if percept.key == self.task.start_key and not self._is_held(percept.at):
                self._start_trial(percept.at)
            case phase if phase in BEFORE_PROMPT and self.task.has_foreperiod:
                self._disturbed()
            case Phase.ONSET:
                self._trial.early.append(percept)
            case Phase.RESPONSE:
                self._judge(percept)

    @on(REACH)
    def reach_perceived(self, percept: m.ReachPerceived) -> None:
        match self._phase:
            case Phase.ONSET:
                self._trial.early.append(percept)
            case Phase.RESPONSE:
                self._judge(percept)

    @on(PASTE)
    def pasted(self, paste: m.Pasted) -> None:
        self._last_key = paste.at
        if self._phase in IN_TRIAL:
            self._trial.flag("paste")
        if self._phase in BEFORE_PROMPT and self.task.has_foreperiod:
            self._disturbed()

    @on(FOCUS)
    def focus_changed(self, focus: m.FocusChanged) -> None:
        self._focused = focus.focused
        if self._phase in IN_TRIAL and not focus.focused:
            self._trial.flag("focus_lost")

    def _disturbed(self) -> None:
        """A key where none belongs: wait for quiet, and begin the foreperiod anew."""
        if self._phase is not Phase.QUIET:
            self._trial.false_starts += 1
            self.cancel_timer("foreperiod")
            self._await_quiet()
        else:
            self._set_quiet_timer()
            if self.now - self._restless_since > HELD:
                self._restless_since = self.now
                self._wait(Phase.QUIET, "held")

    def _judge(self, percept: m.Percept) -> None:
        if percept.repeat:
            self._trial.flag("repeat_key")
            return
        trial = self._trial.view()
        self._trial.remember(percept)
        if trial.latency_ms(percept.at) > self.parameters.response_timeout_ms:
            self._trial.flag("late_key")
            self._finish(self.task.timed_out(trial))
        elif isinstance(result := self.task.perceived(trial, percept), Again):
            self._try_again(result)
        elif result is not None:
            self._finish(result)

    def _try_again(self, again: Again) -> None:
        self._agains += 1
        if self._agains < MOST_AGAIN:
            self._void(again.reason)
            self._begin_trial(again.words)
        else:
            self._finish(Result(correct=False, flags=("unmeasured", again.reason), remark=again.words))

    def _finish(self, result: Result) -> None:
        """Record the trial, and go on to the next or to the end of the attempt."""
        self.cancel_timers()
        latency = self._trial.latency_ms(result)
        if latency is not None and latency < self.parameters.min_rt_ms:
            result = msgspec.structs.replace(result, flags=(*result.flags, "anticipation"))
        self._agains = 0
        self._unmarked = result
        self._marked = self._trial.mark
        if self._marked:
            result = self._marked.applied(result)
        self.emit(TRIAL, self._trial.ended(result))
        self._course.results.append(result)
        self._last_trial = self._course.last_trial
        if self._course.is_attempt_done:
            self._end_attempt()
        else:
            self._trial = self._course.next_trial()
            self._begin_trial()

    def _mark(self, mark: Mark) -> None:
        """Mark the trial under way, or the last one, which is then scored once more; again: take the mark back."""
        if self._phase in IN_TRIAL and self._phase is not Phase.START:
            self._mark_open(None if self._trial.mark is mark else mark)
            return
        if self._phase not in MARKABLE:
            return
        if (last := self._course.amendable) is None:
            return
        attempt, trial = last
        self._marked = None if self._marked is mark else mark
        marked = self._marked.applied(self._unmarked) if self._marked else self._unmarked
        name = self._marked.name if self._marked else ""
        self.emit(MARKED, m.TrialMarked(attempt=attempt, trial=trial, mark=name, correct=marked.correct))
        if scored := self._course.amend(marked):
            self.emit(ATTEMPT_ENDED, scored.ended)
            if scored.level:
                self.emit(LEVEL, scored.level)
            self._wait(self._phase)

    def _mark_open(self, mark: Mark | None) -> None:
        self._trial.mark = mark
        attempt, trial = self._course.attempt, self._course.trial
        name, correct = (mark.name, mark.counts) if mark else ("", True)
        self.emit(MARKED, m.TrialMarked(attempt=attempt, trial=trial, mark=name, correct=correct))

    def _void(self, reason: str) -> None:
        """Break a trial off; it will be repeated."""
        self.cancel_timers()
        if self._phase in IN_TRIAL:
            if self._trial.mark:
                self._mark_open(None)
            self.emit(VOIDED, self._trial.voided(reason))
            self._trial = self._trial.anew()

    # --- waiting ------------------------------------------------------------------------------------------------

    @property
    def _reason(self) -> str:
        """Why the session stands still: the disk, before anything a person said."""
        if self._obstacles.disk_refuses and self._phase in (Phase.PAUSED, Phase.CLOSING):
            return "storage"
        return self._pause_reason if self._phase is Phase.PAUSED else ""

    def _wait(self, phase: Phase, reason: str = "") -> None:
        """Enter a phase, and say what the session waits for."""
        self._phase = phase
        why = reason or self._reason
        notice = self._notice_for(phase)
        detail = self._obstacles.says(why)
        self.emit(WAITING, waiting(phase, self._course, self.task, notice=notice, reason=why, detail=detail))

    def _notice_for(self, phase: Phase) -> str:
        """What has to be known first: that a trial is done again, or that the level is another."""
        if phase is Phase.READY and self._course.level != self._told_level:
            return self.task.notice(self._course.level, self._told_level)
        return self._notice if phase is Phase.START else ""

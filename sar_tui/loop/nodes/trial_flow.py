"""Runs trials, each from its start to its row (thesis 3.2.3)."""

from abc import ABC, abstractmethod
from collections.abc import Callable

import msgspec

from sar_tui.loop.clock import STALLED
from sar_tui.loop.node import TimedNode, on
from sar_tui.loop.session_phase import BEFORE_PROMPT, IN_TRIAL, Phase
from sar_tui.loop.task import Task
from sar_tui.loop.topics import (
    ACTING,
    CUE,
    FOCUS,
    FRAME,
    PASTE,
    PERCEIVED,
    PROMPT,
    REACH,
    SHOWN,
    STORED,
    TONE_BEGAN,
    TONE_DUE,
    TONES_AHEAD,
    TRIAL,
    TRIAL_FEEDBACK,
    TRIAL_FEEDBACK_SHOWN,
    TYPED,
    UNREADABLE,
    VOIDED,
)
from sar_tui.loop.trial import OpenTrial
from sar_tui.loop.trial_feedback import trial_feedback
from sar_tui.model import frames
from sar_tui.model import messages as m
from sar_tui.model.trial_types import Again, Mark, Result, Results, complete
from sar_tui.model.units import MS, SECOND
from sar_tui.rules.held_key import HeldKey
from sar_tui.rules.key_guard import GuardedPress, KeyGuard

GRACE = 50 * MS
"""Wait after the time-out for responses that were stamped in time but are handled late."""
MAX_PRESENTATIONS = 3
"""A trial that cannot be measured is shown this many times in total; then it counts as missed."""
HELD_NOTICE = 3 * SECOND
"""After this long without quiet the participant is asked to release the keys."""


class TrialFlow(TimedNode, ABC):
    """Runs one trial after the other. Subclasses run the attempts and the session.

    A trial runs (start) → quiet → foreperiod → (storing) → onset → response → (result). A key in
    the foreperiod restarts it. A pause, a lost sensor or the end of the program voids the trial,
    which is then repeated under the same number with the same prompt. No prompt is shown while the
    agent speaks or moves. With several seats, a trial ends for all of them at once, and keys of a
    seat whose turn it is not are ignored.
    """

    def __init__(self, task: Task) -> None:
        super().__init__()
        self.task = task
        self.parameters = task.parameters
        self._phase = Phase.INSTRUCTIONS
        self._trial: OpenTrial
        self._stored = (0, 0)
        self._last_trial = (0, 0)
        self._focused = True
        self._rules = 3
        self._repeats = 0
        self._last_key: int | None = None
        self._result_lasts = 0
        self._start_key = HeldKey()
        self._key_guard = KeyGuard()
        self._awaiting_quiet_since = 0
        self._notice = ""
        self._is_agent_acting = False
        self._after_agent: Callable[[], None] = self._prepare_prompt

    @abstractmethod
    def _wait(self, phase: Phase, reason: str = "") -> None:
        """Enter a phase, and publish what the session waits for."""

    @abstractmethod
    def _key_between_trials(self, percept: m.KeyPerceived, press: GuardedPress) -> None:
        """Handle a key while no trial is under way."""

    @abstractmethod
    def _trial_done(self, results: Results) -> Results:
        """Take the results of a trial. Returns them as they are stored."""

    @abstractmethod
    def _next(self) -> None:
        """Begin the next trial, or end the attempt."""

    @abstractmethod
    def _mark_open_trial(self, mark: Mark | None) -> None:
        """Mark the open trial, or remove its mark."""

    @property
    def pictures_to_come(self) -> tuple[str, ...]:
        """Pictures of the prompt that comes next, and of its frames; none if no trial has begun."""
        if self._phase not in IN_TRIAL:
            return ()
        stimulus = self._trial.stimulus
        return tuple(
            filter(None, (stimulus.picture, *(frame.picture for frame in stimulus.frames)))
        )

    # --- before the prompt

    def _begin_trial(self, notice: str = "") -> None:
        """Wait for the participant to start the trial, if the task has a start key; else prepare
        its prompt.
        """
        self._notice = notice
        if self._trial.tones:
            self.emit(TONES_AHEAD, m.TonesAhead(tones=self._trial.tones))
        self._when_agent_is_still(
            self._await_start if self.task.start_key else self._prepare_prompt
        )

    def _when_agent_is_still(self, step: Callable[[], None]) -> None:
        """Take ``step`` as soon as the agent neither speaks nor moves."""
        if self._is_agent_acting:
            self._after_agent = step
            self._wait(Phase.AGENT)
        else:
            step()

    @on(ACTING)
    def agent_acted(self, agent: m.AgentActing) -> None:
        self._is_agent_acting = agent.acting
        if not agent.acting and self._phase is Phase.AGENT:
            self._after_agent()

    def _await_start(self) -> None:
        self._wait(Phase.START)

    def _start_trial(self, at: int) -> None:
        self._trial.started = at
        self._prepare_prompt()

    def _prepare_prompt(self) -> None:
        if self.task.has_foreperiod:
            self._await_quiet()
        else:
            self._when_agent_is_still(self._show_when_stored)

    def _show_when_stored(self) -> None:
        if self._stored == self._last_trial:
            self._show()
        else:
            self._wait(Phase.STORING)

    @on(STORED)
    def stored(self, stored: m.Stored) -> None:
        self._stored = (stored.attempt, stored.trial)
        if self._phase is Phase.STORING and self._stored == self._last_trial:
            self._show()

    def _await_quiet(self) -> None:
        """Begin the foreperiod when no key has been pressed for a moment."""
        self._awaiting_quiet_since = self.now
        self._wait(Phase.QUIET)
        self._set_quiet_timer()

    def _set_quiet_timer(self) -> None:
        quiet = self.parameters.quiet_ms * MS
        self.set_timer(
            "quiet", self.now if self._last_key is None else max(self.now, self._last_key + quiet)
        )

    def _begin_foreperiod(self) -> None:
        wait = self._trial.draw_foreperiod(
            self.parameters.foreperiod_min_ms, self.parameters.foreperiod_max_ms
        )
        self._wait(Phase.FOREPERIOD)
        self.set_timer("foreperiod", self.now + wait)
        if cue := self._trial.stimulus.cue:
            self.set_timer("cue", self.now + wait - cue.lead_ms * MS)

    def timer(self, name: str, late: int) -> None:
        match name:
            case "quiet" if self._is_agent_acting:
                self._when_agent_is_still(self._await_quiet)
            case "quiet":
                self._begin_foreperiod()
            case "cue" | "foreperiod" if late > STALLED and self._rules >= 3:
                self._begin_foreperiod_anew()
            case "cue":
                self.emit(CUE, self._trial.cue(self.now))
            case "foreperiod":
                self._show_when_stored()
            case "frame" if late > STALLED:
                self._repeat_stalled()
            case "frame":
                self.emit(FRAME, self._trial.frame())
            case "timeout" if late > STALLED:
                self._repeat_stalled()
            case "timeout":
                self.cancel_timer("frame")
                self._trial.lag = late
                self.set_timer("grace", self.now + GRACE)
            case "result":
                self._next()
            case "grace":
                self._judge_early()
                if self._phase is Phase.RESPONSE:
                    self._finish(self.task.timed_out(self._trial.view()))

    def _restart_foreperiod(self) -> None:
        """Wait for quiet again after a key, and restart the foreperiod."""
        if self._phase is not Phase.QUIET:
            self._trial.false_starts += 1
            self._begin_foreperiod_anew()
        else:
            self._set_quiet_timer()
            if self.now - self._awaiting_quiet_since > HELD_NOTICE:
                self._awaiting_quiet_since = self.now
                self._wait(Phase.QUIET, "held")

    def _begin_foreperiod_anew(self) -> None:
        self.cancel_timer("foreperiod")
        self.cancel_timer("cue")
        self._await_quiet()

    # --- prompt and response

    def _show(self) -> None:
        if not self._focused:
            self._trial.flag("focus_lost")
        self.emit(PROMPT, self._trial.prompt(self.parameters.response_timeout_ms, self.now))
        self._request_tone()
        self._wait(Phase.ONSET)

    @on(SHOWN)
    def shown(self, shown: m.Shown) -> None:
        """Store the onset, judge what was pressed since the prompt or its frame was published, and
        wait for more.
        """
        if self._phase not in (Phase.ONSET, Phase.RESPONSE) or not self._trial.is_shown_by(shown):
            return
        self._phase = Phase.RESPONSE
        was_timed = self._trial.timeout_at is not None
        self._trial.set_onset(shown)
        if (over := self._trial.timeout_at) is not None and not was_timed:
            self.set_timer("timeout", over)
        if (due := self._trial.next_onset_due) is not None:
            self.set_timer("frame", due - frames.LEAD)
            self._request_tone()
        self._judge_early()

    def _request_tone(self) -> None:
        if due := self._trial.next_tone():
            self.emit(TONE_DUE, due)

    @on(TONE_BEGAN)
    def tone_began(self, began: m.ToneBegan) -> None:
        if self._phase in (Phase.ONSET, Phase.RESPONSE):
            self._trial.tone_began(began)

    def _judge_early(self) -> None:
        """Judge what was pressed while a prompt or a frame was on its way to the screen."""
        early, self._trial.early = self._trial.early, []
        for percept in early:
            if self._phase is Phase.RESPONSE:
                self._judge(percept)

    @on(PERCEIVED)
    def perceived(self, percept: m.KeyPerceived) -> None:
        self._last_key = percept.at
        is_start = (
            percept.key == self.task.start_key and self._start_key.press(percept.at) != "held"
        )
        press = self._key_guard.press(percept.key, percept.at)
        if self._phase in IN_TRIAL:
            self._key_in_trial(percept, is_start)
        else:
            self._key_between_trials(percept, press)

    def _key_in_trial(self, percept: m.KeyPerceived, is_start: bool) -> None:
        match self._phase:
            case Phase.START if is_start:
                self._start_trial(percept.at)
            case phase if phase in BEFORE_PROMPT and self.task.has_foreperiod:
                self._restart_foreperiod()
            case Phase.ONSET | Phase.RESPONSE:
                self._respond(percept)

    @on(REACH)
    def reach_perceived(self, percept: m.ReachPerceived) -> None:
        if self._phase in (Phase.ONSET, Phase.RESPONSE):
            self._respond(percept)

    def _respond(self, percept: m.Percept) -> None:
        """Judge a percept; while a prompt or a frame is on its way to the screen, as soon as its
        onset is known.
        """
        if self._trial.is_drawing:
            self._trial.early.append(percept)
        else:
            self._judge(percept)

    @on(PASTE)
    def pasted(self, paste: m.Pasted) -> None:
        self._last_key = paste.at
        if self._phase in IN_TRIAL:
            self._trial.flag("paste")
        if self._phase in BEFORE_PROMPT and self.task.has_foreperiod:
            self._restart_foreperiod()

    @on(UNREADABLE)
    def input_dropped(self, dropped: m.InputDropped) -> None:
        if self._phase in IN_TRIAL:
            self._trial.flag("unreadable_input")

    @on(FOCUS)
    def focus_changed(self, focus: m.FocusChanged) -> None:
        self._focused = focus.focused
        if self._phase in IN_TRIAL and not focus.focused:
            self._trial.flag("focus_lost")

    def _judge(self, percept: m.Percept) -> None:
        if percept.seat not in self._trial.seats:
            if percept.seat:
                self._trial.flag("other_seat")
            return
        if percept.repeat:
            self._trial.flag("repeat_key")
            if self._rules >= 6 and isinstance(percept, m.KeyPerceived):
                self._trial.remember_repeat(percept)
            return
        if percept.stalled and self._trial.stimulus.signals:
            self._repeat_stalled()
            return
        if not self._trial.is_awaited(percept.at):
            self._trial.flag("early_key")
            return
        trial = self._trial.view()
        if trial.latency_ms(percept.at) > self._trial.timeout_ms:
            self._trial.remember(percept)
            self._trial.flag("late_key")
            self._finish(self.task.timed_out(trial))
        elif self._trial.expects_text and isinstance(percept, m.KeyPerceived):
            self._type(percept)
        else:
            self._take(percept)

    def _type(self, key: m.KeyPerceived) -> None:
        """Take a key of a typed text, show the text so far, and judge it when it is sent."""
        before = self._trial.typed()
        if text := self._trial.type(key):
            self._take(text)
        if self._phase is Phase.RESPONSE and (typed := self._trial.typed()) != before:
            self.emit(TYPED, typed)

    def _take(self, percept: m.Percept) -> None:
        """Let the task judge a percept."""
        trial = self._trial.view()
        self._trial.remember(percept)
        if isinstance(result := self.task.perceived(trial, percept), Again):
            self._try_again(result)
        elif result is not None:
            self._finish(result)

    def _repeat_stalled(self) -> None:
        """Repeat the trial: the program was suspended in it, so the time of its response is not
        known.
        """
        self._void("stalled")
        self._go_on()

    def _go_on(self) -> None:
        """Go on with the attempt after an interruption: with the trial that was voided."""
        self._begin_trial()

    # --- the end of a trial

    def _try_again(self, again: Again) -> None:
        self._repeats += 1
        if self._repeats < MAX_PRESENTATIONS:
            self._void(again.reason)
            self._begin_trial(again.text)
        else:
            self._finish(
                Result(correct=False, flags=("unmeasured", again.reason), remark=again.text)
            )

    def _finish(self, result: Result | Results) -> None:
        """Record the trial, and continue with the next one or the end of the attempt."""
        self.cancel_timers()
        results = result if isinstance(result, dict) else dict.fromkeys(self._trial.seats, result)
        if set(results) != set(self._trial.seats):
            given, due = ", ".join(map(str, results)) or "none", ", ".join(self._trial.seats)
            raise ValueError(
                f"the results of a trial are for the seats {given}; they are due for {due}"
            )
        self._repeats = 0
        complete_results = {
            seat: complete(mine, self.task.Details) for seat, mine in results.items()
        }
        stored = self._trial_done(
            {seat: self._flagged(mine) for seat, mine in complete_results.items()}
        )
        for seat, mine in stored.items():
            self.emit(TRIAL, self._trial.ended(mine, seat))
        shown = trial_feedback(
            self._trial.situation, stored, self.task.seats, self.parameters.trial_feedback_ms
        )
        if shown is None:
            self._next()
        else:
            self._result_lasts = shown.duration
            self.emit(TRIAL_FEEDBACK, shown)
            self.set_timer("result", self.now + shown.duration)
            self._wait(Phase.RESULT)

    @on(TRIAL_FEEDBACK_SHOWN)
    def trial_feedback_shown(self, shown: m.TrialFeedbackShown) -> None:
        """Show the answer to a trial for its time, from when it reached the terminal."""
        if self._phase is Phase.RESULT and (shown.attempt, shown.trial) == self._last_trial:
            self.set_timer("result", shown.at + self._result_lasts)

    def _end_result(self) -> None:
        """Go on at once if the answer to a trial is shown: that trial is over."""
        if self._phase is Phase.RESULT:
            self.cancel_timer("result")
            self._next()

    def _flagged(self, result: Result) -> Result:
        """Flag a result that came too soon to be a response."""
        latency = self._trial.latency_ms(result)
        if latency is None or latency >= self.parameters.min_rt_ms:
            return result
        return msgspec.structs.replace(result, flags=(*result.flags, "anticipation"))

    def _void(self, reason: str) -> None:
        """Void the open trial, so that it is repeated."""
        self.cancel_timers()
        if self._phase in IN_TRIAL:
            if self._trial.mark:
                self._mark_open_trial(None)
            self.emit(VOIDED, self._trial.voided(reason))
            self._trial = self._trial.repeated()

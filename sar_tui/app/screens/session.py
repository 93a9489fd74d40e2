"""The session's screen, from the instructions to the summary."""

import functools
from collections.abc import Sequence

from sar_tui.app.prompt_onset import Onset, report_onset, report_trial_feedback
from sar_tui.app.screens.pause import PauseMenu
from sar_tui.app.screens.session_keys import KeysScreen
from sar_tui.app.screens.summary import Summary
from sar_tui.loop.agent_state import AWAITED
from sar_tui.loop.topics import ACTING, MARKERS, RECALL, STEP_ENDED
from sar_tui.model.messages import (
    AgentActing,
    AttemptEnded,
    AttemptStarted,
    Prompt,
    Recall,
    SessionEnded,
    TrialFeedback,
    Waiting,
)
from sar_tui.tui.paint_now import paint_now
from sar_tui.widgets.big_prompt import BigPrompt


class SessionScreen(KeysScreen):
    """The stage of a session (see `screen_output.Stage`).

    Nothing moves while a response is awaited.
    """

    AUTO_FOCUS = ""
    _warned_of = ""
    _has_warned = False

    def on_mount(self) -> None:
        self._show_attempts(0)
        self._live.begin(self.app, self._broken)
        self._live.run.session.bus.subscribe(MARKERS, lambda _: self._warn())
        self._live.run.session.bus.subscribe(ACTING, self._agent_acted)
        self._live.run.session.bus.subscribe(STEP_ENDED, self.step_ended)
        if self.app.sync_flash:
            from sar_tui.app.screens.sync_signal import SyncScreen

            self.app.push_screen(SyncScreen(self._live))

    def on_unmount(self) -> None:
        self._stop_countdown()
        self._gc.end_attempt()

    @property
    def can_save(self) -> bool:
        """False while the session waits for a disk that cannot be written to."""
        return self._waiting is None or self._waiting.reason != "storage"

    # --- the stage

    def show_prompt(self, prompt: Prompt) -> None:
        """Show the prompt, and report when it reached the terminal."""
        onset = report_onset(self, self._live, prompt)
        if self._shown != "prompt":
            self._stage("prompt")
        self._draw(prompt, 0, onset)

    @property
    def holds_frames(self) -> bool:
        """True if the driver flushes a frame when it is due, not before."""
        return bool(getattr(self.app._driver, "can_stamp_onset", False))

    def show_frame(self, prompt: Prompt, frame: int, due: int) -> None:
        """Show a later frame of the prompt when it is due, and report when it reached the
        terminal.
        """
        self._draw(prompt, frame, report_onset(self, self._live, prompt, frame, due))

    def _draw(self, prompt: Prompt, frame: int, onset: Onset) -> None:
        widget = self.query_one(BigPrompt)
        onset.picture = widget.show(prompt.shown(frame))
        if prompt.frames:
            paint_now(widget)

    def show_typed(self, prompt: Prompt, text: str) -> None:
        """Show the text typed so far, below the prompt or its last frame."""
        self.query_one(BigPrompt).show(prompt.shown(len(prompt.frames) - 1, text))

    def clear_prompt(self) -> None:
        self._gc.end_trial()
        self.query_one(BigPrompt).clear()

    def show_trial_feedback(self, feedback: TrialFeedback) -> None:
        """Show the answer to a trial, and report when it reached the terminal."""
        report_trial_feedback(self, self._live, feedback)
        self.query_one(BigPrompt).show_answer(feedback.text, feedback.halves)

    def begin_attempt(self, started: AttemptStarted) -> None:
        if self._has_warned:
            self.app.clear_notifications()  # nothing may vanish while a response is awaited
            self._has_warned = False
        self._bars = {}
        self._goal = self._waiting.goal if self._waiting else ""
        self._gc.begin_attempt()

    def progress(self, done: int) -> None:
        self._show_trials(done)

    def end_attempt(self, ended: AttemptEnded) -> None:
        self._gc.end_attempt()
        self._show_attempts(ended.attempt)

    def wait(self, waiting: Waiting) -> None:
        before, self._waiting = self._waiting, waiting
        self._stop_countdown()
        entered = before is None or before.stage != waiting.stage
        if before is None:
            self._show_trials(0)
        if before is not None and before.stage == "paused" and waiting.attempt > before.attempt:
            self._show_trials(0)  # the attempt was skipped
        if self._marks.follow():
            self._show_position(waiting)
        if waiting.what == "foreperiod" and before is not None and before.reason == "held":
            self.clear_agent("listening")
        self._update_motion(waiting)
        self._warn()
        if before is not None and before.what == "result" and waiting.what != "response":
            self.query_one(
                BigPrompt
            ).clear()  # the next prompt, where no wait precedes it, has replaced the answer
        self._prepare_pictures(waiting)
        if waiting.what in ("foreperiod", "response", "result"):
            if waiting.what == "response":
                self._gc.begin_trial()
            return
        text = self._waiting_text(waiting)
        if waiting.stage == "trial" and waiting.what == "quiet":
            self.query_one(BigPrompt).redraw()
        if waiting.reason == "held":
            self.ask(self.tr("Please let go of the keys for a moment."))
        elif text is not None:
            self._show_text(waiting, text)
        elif waiting.stage == "trial" and (entered or self._shown != "prompt"):
            self._begin_trials(waiting)
        elif waiting.stage == "paused":
            self._show_position(waiting)
            self._show_trials(waiting.trial - 1)
            can_skip = bool(self.app.patient) and self._live.run.session.can_skip_attempt
            may_be_mistake = waiting.reason == "finished" and self._live.in_first_attempt
            self.query_one(PauseMenu).open(
                waiting.reason, can_skip=can_skip, may_be_mistake=may_be_mistake
            )
            self._stage("menu")
            self.app.screen_keys.changed(self)

    def _prepare_pictures(self, waiting: Waiting) -> None:
        """Prepare what the next prompt shows, before it comes."""
        to_come = self._live.run.session.pictures_to_come if self._pictures else ()
        if to_come and waiting.what != "response":
            self.call_after_refresh(self.query_one(BigPrompt).prepare, to_come)

    def _warn(self) -> None:
        """Tell a therapist who is there, once and never in a trial, that markers are lost or tones
        not heard.
        """
        trouble, in_trial = (
            self._live.trouble,
            self._waiting is None or self._waiting.stage == "trial",
        )
        if trouble and trouble != self._warned_of and not in_trial and not self.app.patient:
            self._warned_of, self._has_warned = trouble, True
            self.app.notify(trouble, severity="warning", timeout=30)

    def _update_motion(self, waiting: Waiting) -> None:
        """Let the agent move and look for edited themes, except during a trial."""
        is_awaited = waiting.stage == "trial" and waiting.what in AWAITED
        self.app.themes.look_for_edits(not is_awaited and waiting.what != "quiet")
        self.let_agent_move(not is_awaited)

    def _begin_trials(self, waiting: Waiting) -> None:
        self._show_trials(waiting.trial - 1)
        self._show_position(waiting)
        self.query_one(BigPrompt).clear()
        self.clear_agent("listening")
        self._stage("prompt")

    def end(self, ended: SessionEnded) -> None:
        task, bus = self._live.run.session.task, self._live.run.session.bus
        attempts = {seat: bus.call(RECALL, Recall(seat=seat)).attempts for seat in task.seats}
        codes = self._live.run.participants if len(task.seats) > 1 else {}
        names = [f"{task.seat_name(seat)} ({code})" for seat, code in codes.items()]
        status = "mistake" if self._live.is_mistake else ended.status
        self.query_one(Summary).show(*attempts.values(), status=status, names=names)
        self._stage("summary")
        self.app.screen_keys.changed(self)
        if ended.status == "completed" and len(task.seats) == 1 and not self._live.run.rescue_file:
            counted = [attempt for attempt in attempts[task.seats[0]] if not attempt.practice]
            compare = functools.partial(self._compare, counted)
            self.run_worker(compare, name="comparison", thread=True, exit_on_error=False)

    def _agent_acted(self, acting: AgentActing) -> None:
        self._is_goodbye_held |= self._live.run.session.ended and acting.awaits_operator
        if self._shown == "summary":
            self.query_one(Summary).wait(awaits_goodbye=self._awaits_goodbye)

    def _compare(self, attempts: Sequence[AttemptEnded]) -> None:
        """Add the last comparable session to the summary. Runs in a thread: it reads all of the
        person's sessions.
        """
        from sar_tui.runs.previous import beside_earlier_sessions

        run = self._live.run
        if words := beside_earlier_sessions(
            self.app.folder, run.session.task, run.id, attempts, self.tr
        ):
            self.app.call_from_thread(self.query_one(Summary).compare, words)

    def _broken(self, error: str) -> None:
        """Record that the task raised, so that the app ends with this message; the data is safe."""
        self._gc.end_attempt()
        self.app.screen_keys.changed(self)
        self.app.failure = (
            f"The task {self._live.run.session.task.name} failed ({error}). What "
            "was done so far is kept."
        )

"""The session's screen, from the instructions to the summary."""

import functools
from collections.abc import Sequence
from typing import ClassVar

from textual import events
from textual.app import ComposeResult
from textual.binding import ActiveBinding, Binding, BindingType
from textual.containers import Horizontal
from textual.widgets import ContentSwitcher, Static

from sar_tui.app.agent.screen_base import AgentScreen
from sar_tui.app.live import LiveSession
from sar_tui.app.prompt_onset import report_onset
from sar_tui.app.screens.large_message import is_roomy
from sar_tui.app.screens.mark_keys import MarkKeys
from sar_tui.app.screens.message_panel import MessagePanel
from sar_tui.app.screens.pause import PauseMenu
from sar_tui.app.screens.summary import Summary
from sar_tui.app.screens.waiting_text import WaitingText, help_text, key_name, waiting_text
from sar_tui.framework.agent_state import AWAITED
from sar_tui.framework.clock import MS, SECOND, Handle
from sar_tui.framework.messages import (
    AttemptEnded,
    AttemptStarted,
    Feedback,
    Prompt,
    Recall,
    SessionCommand,
    SessionEnded,
    TrialMarked,
    Waiting,
)
from sar_tui.framework.topics import RECALL
from sar_tui.tui.gc_control import GcControl
from sar_tui.widgets.big_prompt import BigPrompt
from sar_tui.widgets.goal_bar import GoalBar, bar_of
from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.progress_line import ProgressLine

_MARKABLE = ("trial", "answer", "rest", "review")
"""Stages in which there is a trial to mark; and before an attempt, except the first."""

_BETWEEN = ("attempt", "answer", "rest", "review")
"""Stages between two attempts, and after the last."""


_DRAWING_HEIGHT = 40
"""Least rows of a window in which a drawing leaves room above the agent."""


class SessionScreen(AgentScreen):
    """The stage of a session (see `screen_output.Stage`), which also reads its keys.

    Nothing moves while a response is awaited.
    """

    AUTO_FOCUS = ""
    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape", "pause", "Pause", id="pause")]

    def __init__(self, live: LiveSession) -> None:
        super().__init__(live)
        self._gc = GcControl()
        self._waiting: Waiting | None = None
        self._last_key = ("", 0.0)
        self._shown: str | None = "message"
        self._position = ""
        self._bars: dict[str, GoalBar] = {}
        self._goal = ""
        self._agent_seat = ""
        self._countdown: Handle | None = None

    @functools.cached_property
    def _marks(self) -> MarkKeys:
        """Keys of the therapist's marks."""
        session = self._live.run.session
        return MarkKeys(session.task.marks, self.tr, lambda: session.trial_mark)

    @property
    def help_text(self) -> str:
        """Instructions of the task, and the keys to pause, ask for feedback and mark a trial."""
        return help_text(self._live.run.session.task, self.tr)

    def compose(self) -> ComposeResult:
        session = self._live.run.session
        with Horizontal(id="top"):
            codes = ", ".join(self._live.run.participants.values())
            yield Static(f"{self.tr(session.task.title)} · {codes}", id="task", markup=False)
            yield from self.compose_voice()
            yield Static("", id="where", markup=False)
        yield Static("", id="above")
        with ContentSwitcher(initial="message", id="stage"):
            yield MessagePanel(id="message")
            yield BigPrompt(id="prompt", draw=self._live.view.prompt_lines)
            yield PauseMenu(id="menu")
            yield Summary(session.task.metric, self._live.view.facts, id="summary")
        yield from self.compose_agent()
        with Horizontal(id="progress"):
            yield ProgressLine(id="trials")
            yield ProgressLine(id="attempts")
        yield KeyFooter()

    def on_mount(self) -> None:
        self._show_attempts(0)
        self._live.begin(self.app, self._broken)

    def on_unmount(self) -> None:
        self._stop_countdown()
        self._gc.end_attempt()

    # --- the keyboard ------------------------------------------------------------------------------------

    def on_key(self, event: events.Key) -> None:
        waiting = self._waiting
        is_repeat = self._is_repeat(event)
        if waiting is None or isinstance(self.focused, PauseMenu):
            return
        if self._shown == "menu":  # a click beside the menu took the focus from it
            self.set_focus(self.query_one(PauseMenu))
        if waiting.stage != "trial" and event.key in ("question_mark", "f1", "ctrl+p"):
            return
        if waiting.what == "nothing":
            if event.key in ("enter", "space"):
                event.stop()
                if not is_repeat:
                    self.dismiss()
            return
        if event.key not in ("escape", "f1", "ctrl+p"):
            event.stop()
            event.prevent_default()
        if event.key in self._marks:
            if not is_repeat:
                self._press_mark(event.key, waiting)
            return
        at = self._live.stamp(event.time)
        stalled = self._gc.is_stalled(round(at * SECOND))
        self._live.keyboard.pressed(event.key, event.character, at, self._gc.lag, stalled)
        self._correct_key(event.key, waiting)

    def _press_mark(self, key: str, waiting: Waiting) -> None:
        """Mark the trial, or ask for the key again if it would replace another mark."""
        if mark := self._marks.press(key):
            self._live.operate(SessionCommand(command="mark", actor="therapist", reason=mark.name))
        else:
            self._show_position(waiting)

    def _correct_key(self, key: str, waiting: Waiting) -> None:
        """Say which key is awaited after Enter was pressed for the start key, or the other way round."""
        start = self._live.run.session.task.start_key
        wanted = {"enter": "enter", "start": start}.get(waiting.what)
        if start and wanted and key in ("enter", start) and key != wanted:
            later = self.tr("({key} comes later.)", key=key_name(key, self.tr))
            self.query_one(MessagePanel).correct(later)

    def _is_repeat(self, event: events.Key) -> bool:
        """True if a key is held or bounces, as perception judges it: the Enter before the summary must not close it."""
        (last, before), now = self._last_key, self._live.stamp(event.time)
        self._last_key = (event.key, now)
        interval = self._live.run.session.task.parameters.repeat_interval_ms * MS / SECOND
        return event.key == last and now - before < interval

    def on_paste(self, event: events.Paste) -> None:
        event.stop()
        self._live.keyboard.pasted(len(event.text), self._live.stamp(event.time))

    @property
    def active_bindings(self) -> dict[str, ActiveBinding]:
        """The screen's bindings, and the keys of marks while there is a trial to mark."""
        found, waiting = super().active_bindings, self._waiting
        if waiting is None or not (waiting.stage in _MARKABLE or (waiting.stage == "attempt" and waiting.attempt > 1)):
            return found
        first = {key: each for key, each in found.items() if key == "escape"}
        return first | self._marks.bindings(found, self.size.width, self) | found

    def on_resize(self) -> None:
        """Name the keys of marks as far as there is room, and give the pause menu more of it."""
        self.set_class(is_roomy(*self.app.size), "roomy")
        self.refresh_bindings()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool:
        """Offer a pause if there is something to pause, and its menu while a sensor is awaited."""
        waiting = self._waiting
        if action != "pause" or waiting is None:
            return action != "pause"
        return waiting.what == "sensor" or waiting.stage not in ("paused", "ended")

    def action_pause(self) -> None:
        """Pause at once, without a question."""
        self._live.operate(SessionCommand(command="pause"))

    @property
    def is_in_trial(self) -> bool:
        """True in a trial, which is paused when another screen covers this one."""
        return self._waiting is not None and self._waiting.stage == "trial"

    @property
    def can_save(self) -> bool:
        """False while the session waits for a disk that cannot be written to."""
        return self._waiting is None or self._waiting.reason != "storage"

    def on_screen_suspend(self) -> None:
        """Pause a trial that another screen covers: the participant cannot see the prompt."""
        if self.is_in_trial:
            self.action_pause()

    def on_pause_menu_chosen(self, event: PauseMenu.Chosen) -> None:
        self._live.operate(event.act)
        if event.act.reason == "pain" and self._live.run.session.task.parameters.ask_wellbeing:
            from sar_tui.app.wellbeing import ask_after

            self.app.push_screen(ask_after(self.app, self._live, "pause"))

    def on_pause_menu_therapist_asked(self) -> None:
        """Open the therapist's changes, behind the passphrase if there is one."""
        from sar_tui.app.screens.adjust import AdjustScreen
        from sar_tui.app.screens.passphrase import PassphraseScreen

        def entered(is_right: bool | None) -> None:
            if is_right and self._waiting and self._waiting.stage == "paused":
                self.app.push_screen(AdjustScreen(self._live))

        if self.app.passphrase.is_set:
            self.app.push_screen(PassphraseScreen(self.app.passphrase, "pause"), entered)
        else:
            entered(True)

    # --- the stage ---------------------------------------------------------

    def show_prompt(self, prompt: Prompt) -> None:
        """Show the prompt, and report when it reached the terminal."""
        report_onset(self, self._live, prompt)
        if self._shown != "prompt":
            self._stage("prompt")
        self.query_one(BigPrompt).show(prompt)

    def clear_agent(self, face: str) -> None:
        """Remove the words, and the bars that go with them."""
        super().clear_agent(face)
        self._bars = {}

    def clear_prompt(self) -> None:
        self._gc.end_trial()
        self.query_one(BigPrompt).clear()

    def begin_attempt(self, started: AttemptStarted) -> None:
        self._bars = {}
        self._goal = self._waiting.goal if self._waiting else ""
        self._gc.begin_attempt()

    def feedback_given(self, feedback: Feedback) -> None:
        """Show the result beside its goal, with the words that tell it."""
        task = self._live.run.session.task
        who = task.display_name(feedback.seat) if len(task.seats) > 1 else ""
        if bar := bar_of(feedback, task.metric, who):
            self._bars[feedback.seat] = bar
        else:
            self._bars.pop(feedback.seat, None)
        self._show_again()

    def feedback_over(self) -> None:
        """Remove the result: the agent speaks of something else."""
        self._bars = {}
        self._show_again()

    def marked(self, marked: TrialMarked) -> None:
        self._marks.marked()
        if self._waiting:
            self._show_position(self._waiting)

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
        if self._marks.follow():
            self._show_position(waiting)
        if waiting.what == "foreperiod" and before is not None and before.reason == "held":
            self.clear_agent("listening")
        self._update_motion(waiting)
        if waiting.what in ("foreperiod", "response"):
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
            self.query_one(PauseMenu).open(waiting.reason)
            self._stage("menu")

    def _update_motion(self, waiting: Waiting) -> None:
        """Let the agent move and look for edited themes, except during a trial."""
        is_awaited = waiting.stage == "trial" and waiting.what in AWAITED
        self.app.look_for_edits(not is_awaited and waiting.what != "quiet")
        self.let_agent_move(not is_awaited)

    def end(self, ended: SessionEnded) -> None:
        task, bus = self._live.run.session.task, self._live.run.session.bus
        attempts = {seat: bus.call(RECALL, Recall(seat=seat)).attempts for seat in task.seats}
        codes = self._live.run.participants if len(task.seats) > 1 else {}
        names = [f"{task.seat_name(seat)} ({code})" for seat, code in codes.items()]
        self.query_one(Summary).show(*attempts.values(), status=ended.status, names=names)
        self._stage("summary")
        if ended.status == "completed" and len(task.seats) == 1 and not self._live.run.rescue_file:
            counted = [attempt for attempt in attempts[task.seats[0]] if not attempt.practice]
            compare = functools.partial(self._compare, counted)
            self.run_worker(compare, name="comparison", thread=True, exit_on_error=False)

    def _compare(self, attempts: Sequence[AttemptEnded]) -> None:
        """Add the last comparable session to the summary. Runs in a thread: it reads all of the person's sessions."""
        from sar_tui.runs.previous import beside_last_session

        run = self._live.run
        if words := beside_last_session(self.app.folder, run.session.task, run.id, attempts, self.tr):
            self.app.call_from_thread(self.query_one(Summary).compare, words)

    # --- contents ------------------------------------------------------------------------------------

    def _begin_trials(self, waiting: Waiting) -> None:
        self._show_trials(waiting.trial - 1)
        self._show_position(waiting)
        self.query_one(BigPrompt).clear()
        self.clear_agent("listening")
        self._stage("prompt")

    def _show_text(self, waiting: Waiting, text: WaitingText) -> None:
        """Show the text for a wait, and the progress."""
        if waiting.stage in ("attempt", "review", "trial", "paused"):
            self._show_position(waiting)
        if waiting.stage in ("review", "trial", "paused"):
            self._show_trials(waiting.trial - 1)
        if waiting.stage == "trial" and waiting.what != "agent":
            self.clear_agent("listening")
        ask = self.tr("Press {key} to hear how it went.", key=key_name(waiting.ask, self.tr)) if waiting.ask else ""
        drawing = self._live.view.between_attempts() if waiting.stage in ("attempt", "review") else None
        is_between = waiting.stage in _BETWEEN and waiting.attempt > 1
        bars = [bar for _, bar in sorted(self._bars.items())] if is_between else []
        self.query_one(MessagePanel).show(text, bars, drawing, ask)
        is_tight = drawing and self.app.size.height < _DRAWING_HEIGHT
        self._seat_agent("" if not (is_between and self.agent.display) else "drawn" if is_tight else "between")
        self._stage("message")
        if waiting.stage == "rest":
            self._count_down(waiting)

    def _waiting_text(self, waiting: Waiting) -> WaitingText | None:
        left = max(0, waiting.until - self._live.clock.now())
        is_goal_shown = bool(self._bars) and waiting.goal == self._goal
        session = self._live.run.session
        over = session.is_recording_over
        return waiting_text(waiting, session.task, left=left, is_goal_shown=is_goal_shown, is_recording_over=over)

    def _show_again(self) -> None:
        """Show the text for the same wait, because the result beside it has changed."""
        waiting = self._waiting
        if waiting and waiting.stage in _BETWEEN and self._shown == "message" and (text := self._waiting_text(waiting)):
            self._show_text(waiting, text)

    def _count_down(self, waiting: Waiting) -> None:
        """Show the time that is left of a rest, each second."""
        left = waiting.until - self._live.clock.now()
        if left > 0:
            due = self._live.clock.now() + (left % SECOND or SECOND)
            self._countdown = self._live.clock.call_at(due, self._show_again)

    def _stop_countdown(self) -> None:
        if self._countdown:
            self._countdown.cancel()
            self._countdown = None

    def _seat_agent(self, where: str) -> None:
        """Let the agent speak from the middle between two attempts, ``drawn`` above a drawing; else from below."""
        if where != self._agent_seat:
            self._agent_seat, stage = where, self.query_one("#stage")
            self.set_class(bool(where), "middle")
            self.set_class(where == "between", "between")
            if where:
                self.move_child(self.agent, before=stage)
            else:
                self.move_child(self.agent, after=stage)

    def _stage(self, name: str | None) -> None:
        """Show one widget in the middle of the screen, or none."""
        self._shown = name
        if name != "message":
            self._seat_agent("")
        self.query_one("#stage", ContentSwitcher).current = name
        menu = self.query_one(PauseMenu)
        self.set_focus(menu if name == "menu" else None)
        summary = name == "summary"
        self.query_one("#progress").display = not summary
        self.refresh_bindings()

    def _show_position(self, waiting: Waiting) -> None:
        """Show attempt and level in the corner, and the progress at the bottom."""
        is_over = waiting.trial > waiting.trials  # after the last attempt: there is no next level to show
        self._show_attempts(waiting.attempt - (not is_over))
        if not is_over:
            self._position = f"{waiting.attempt_name.capitalize()} · {self.tr('level {level}', level=waiting.level)}"
        parts = (self._marks.text, "" if self._marks.asks else self._position)
        self.query_one("#where", Static).update(" · ".join(filter(None, parts)))

    def _show_attempts(self, done: int) -> None:
        """Show the number of attempts done; practice attempts are counted separately."""
        parameters = self._live.run.session.task.parameters
        kind, total = "Practice", parameters.practice_attempts
        if done >= total:
            kind, total, done = "Attempts", parameters.attempts, done - total
        self.query_one("#attempts", ProgressLine).show(self.tr(kind), done, total)

    def _show_trials(self, done: int) -> None:
        total = self._waiting.trials if self._waiting else 0
        self.query_one("#trials", ProgressLine).show(self.tr(self._live.run.session.task.trials), done, total)

    def _broken(self, error: str) -> None:
        """Record that the task raised, so that the app ends with this message; the data is safe."""
        self._gc.end_attempt()
        self.app.failure = (
            f"The task {self._live.run.session.task.name} failed ({error}). What was done so far is kept."
        )

"""The texts of a session's screen: what it waits for, the last result beside its goal, and the rest
that is left.
"""

from sar_tui.app.live import LiveSession
from sar_tui.app.screens.large_message import is_roomy
from sar_tui.app.screens.message_panel import MessagePanel
from sar_tui.app.screens.session_layout import LayoutScreen
from sar_tui.app.screens.step_text import decline_text, step_text
from sar_tui.app.screens.waiting_text import WaitingText, key_name, waiting_text
from sar_tui.loop.clock import Handle
from sar_tui.model.messages import Feedback, Waiting
from sar_tui.model.units import SECOND
from sar_tui.widgets.goal_bar import GoalBar, bar_of

_BETWEEN = ("attempt", "answer", "step", "rest", "review")
"""Stages between two attempts, and after the last."""
_BEFORE = ("instructions", "attempt", "paused")
"""Stages in which the agent is in the middle too, if there is room."""
_FULL_HEIGHT = 40
"""Least rows of a window in which a drawing, or the instructions, leave room above the agent."""


class MessageScreen(LayoutScreen):
    """The part of a session's screen that tells the participant what it waits for, and how the last
    attempt went.
    """

    def __init__(self, live: LiveSession) -> None:
        super().__init__(live)
        self._bars: dict[str, GoalBar] = {}
        self._goal = ""
        self._countdown: Handle | None = None

    def clear_agent(self, face: str) -> None:
        """Remove the words, and the bars that go with them."""
        super().clear_agent(face)
        self._bars = {}

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

    def _show_text(self, waiting: Waiting, text: WaitingText) -> None:
        """Show the text for a wait, and the progress."""
        if waiting.stage in ("attempt", "review", "trial", "paused"):
            self._show_position(waiting)
        if waiting.stage in ("review", "trial", "paused"):
            self._show_trials(waiting.trial - 1)
        if waiting.stage == "trial" and waiting.what != "agent":
            self.clear_agent("listening")
        ask = (
            self.tr("Press {key} to hear how it went.", key=key_name(waiting.ask, self.tr))
            if waiting.ask
            else ""
        )
        drawing = (
            self._live.view.between_attempts() if waiting.stage in ("attempt", "review") else None
        )
        is_between = waiting.stage in _BETWEEN and waiting.attempt > 1
        shows_result = is_between and not waiting.step
        bars = [bar for _, bar in sorted(self._bars.items())] if shows_result else []
        self.query_one(MessagePanel).show(
            text, bars, drawing, ask or decline_text(waiting.step, self.tr)
        )
        is_tight = (
            drawing or waiting.stage == "instructions"
        ) and self.app.size.height < _FULL_HEIGHT
        is_in_middle = is_between or (waiting.stage in _BEFORE and is_roomy(*self.app.size))
        self._seat_agent(
            "" if not (is_in_middle and self.agent.display) else "drawn" if is_tight else "between"
        )
        self._stage("message")
        if waiting.stage == "rest" or (waiting.step and waiting.until):
            self._count_down(waiting)

    def _waiting_text(self, waiting: Waiting) -> WaitingText | None:
        left = max(0, waiting.until - self._live.clock.now())
        if waiting.step:
            return step_text(waiting.step, self.tr, left)
        is_goal_shown = bool(self._bars) and waiting.goal == self._goal
        session = self._live.run.session
        over = session.is_recording_over
        return waiting_text(
            waiting, session.task, left=left, is_goal_shown=is_goal_shown, is_recording_over=over
        )

    def _show_again(self) -> None:
        """Show the text for the same wait, because the result beside it has changed."""
        waiting = self._waiting
        if (
            waiting
            and waiting.stage in _BETWEEN
            and self._shown == "message"
            and (text := self._waiting_text(waiting))
        ):
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

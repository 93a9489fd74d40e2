"""The screen as an output: shows the session's messages on a stage, and reports when each action
began and ended.
"""

import functools
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

from sar_tui.app.agent.output import DrawnAgent
from sar_tui.loop.bus import Topic
from sar_tui.loop.clock import Handle
from sar_tui.loop.node import on
from sar_tui.loop.topics import (
    ACTING,
    ACTION,
    ATTEMPT_ENDED,
    ATTEMPT_STARTED,
    CUE,
    FEEDBACK,
    FRAME,
    MARKED,
    PROMPT,
    REPORT,
    SESSION_ENDED,
    SHOWN,
    TRIAL,
    TRIAL_FEEDBACK,
    TRIAL_FEEDBACK_SHOWN,
    TYPED,
    VOIDED,
    WAITING,
)
from sar_tui.model.messages import (
    Action,
    AgentActing,
    AttemptEnded,
    AttemptStarted,
    CueGiven,
    Feedback,
    FrameDue,
    OutputReport,
    Prompt,
    PromptVoided,
    SessionEnded,
    Shown,
    TrialEnded,
    TrialFeedback,
    TrialFeedbackShown,
    TrialMarked,
    Typed,
    Waiting,
)
from sar_tui.model.theme import Theme
from sar_tui.outputs.node import OutputNode

if TYPE_CHECKING:
    from sar_tui.app.plain import PlainStage
    from sar_tui.app.screens.session_stage import SessionStage

    Stage: TypeAlias = SessionStage | PlainStage


class ScreenOutput(OutputNode):
    """Shows the session's messages on a stage."""

    emits: ClassVar[tuple[Topic[Any], ...]] = (SHOWN, TRIAL_FEEDBACK_SHOWN, *OutputNode.emits)
    name = "screen"

    def __init__(self, stage: "Stage", theme: Theme, *, shows_agent: bool = True) -> None:
        self._agent = DrawnAgent(stage.agent, is_shown=shows_agent)
        super().__init__(self._agent, "screen", theme)
        self._stage = stage
        self._feedback: dict[str, Feedback] = {}
        self._prompt: Prompt | None = None
        self._frame: Handle | None = None

    @on(CUE)
    def cued(self, cue: CueGiven) -> None:
        """Draw the cue in one frame; nothing may move when the prompt comes."""
        self._agent.cue(cue, super().cued)

    @on(PROMPT)
    def prompted(self, prompt: Prompt) -> None:
        """Show the prompt, without the tone that other outputs play with it."""
        self._prompt = prompt
        self._stage.show_prompt(prompt)

    @on(FRAME)
    def frame_due(self, due: FrameDue) -> None:
        """Draw a frame; where it would be seen at once, not before it is due."""
        if self._prompt is None:
            return
        show = functools.partial(self._stage.show_frame, self._prompt, due.frame, due.at)
        if self._stage.holds_frames:
            show()
        else:
            self._frame = self.bus.clock.call_at(due.at, show)

    @on(TYPED)
    def typed(self, typed: Typed) -> None:
        if self._prompt is not None:
            self._stage.show_typed(self._prompt, typed.text)

    def _clear_prompt(self) -> None:
        if self._frame:
            self._frame.cancel()
        self._stage.clear_prompt()

    def shown(self, shown: Shown) -> None:
        """Report when a prompt or a frame of it reached the terminal. Called by the stage, from any
        thread.
        """
        self.bus.post(SHOWN, shown)

    @on(MARKED)
    def trial_marked(self, marked: TrialMarked) -> None:
        self._stage.marked(marked)

    @on(TRIAL)
    def trial_ended(self, trial: TrialEnded) -> None:
        self._clear_prompt()
        self._stage.progress(trial.trial)

    @on(TRIAL_FEEDBACK)
    def trial_feedback_due(self, feedback: TrialFeedback) -> None:
        self._stage.show_trial_feedback(feedback)

    def trial_feedback_shown(self, shown: TrialFeedbackShown) -> None:
        """Report when the answer to a trial reached the terminal. Called by the stage, from any
        thread.
        """
        self.bus.post(TRIAL_FEEDBACK_SHOWN, shown)

    @on(VOIDED)
    def voided(self, _: PromptVoided) -> None:
        self._clear_prompt()

    @on(ATTEMPT_STARTED)
    def attempt_started(self, started: AttemptStarted) -> None:
        self._stage.begin_attempt(started)

    @on(ATTEMPT_ENDED)
    def attempt_ended(self, ended: AttemptEnded) -> None:
        super().attempt_ended(ended)
        self._stage.end_attempt(ended)

    @on(FEEDBACK)
    def feedback_due(self, feedback: Feedback) -> None:
        """Keep the feedback until it is said: an operator may decide on it."""
        self._feedback[feedback.seat] = feedback

    @on(ACTION)
    def act(self, action: Action) -> None:
        feedback = self._feedback.get(action.seat)
        if action.kind == "feedback" and feedback and feedback.attempt == action.attempt:
            self._stage.feedback_given(feedback)
        elif action.text and not action.joins:
            self._stage.feedback_over()
        self._agent.action = action
        self._agent.update(action)
        super().act(action)

    @on(REPORT)
    def reported(self, report: OutputReport) -> None:
        """Move the mouth while any output speaks; show the words if speech fails."""
        self._agent.update(report)
        if (
            report.part == "say"
            and report.state == "failed"
            and report.action == self._agent.action.id
        ):
            self._stage.agent.voiceless(self._agent.action)

    @on(ACTING)
    def acting(self, acting: AgentActing) -> None:
        self._agent.update(acting)

    @on(WAITING)
    def waiting(self, waiting: Waiting) -> None:
        self._agent.update(waiting)
        self._stage.wait(waiting)

    @on(SESSION_ENDED)
    def session_ended(self, ended: SessionEnded) -> None:
        self._stage.end(ended)

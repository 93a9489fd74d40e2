"""The screen as an output: shows the session's messages on a stage, and reports when each action
began and ended.
"""

import functools
from typing import Any, ClassVar, Protocol

from sar_tui.app.agent.output import AgentStage, DrawnAgent
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


class Stage(Protocol):
    """The part of a session's screen that the output uses."""

    @property
    def agent(self) -> AgentStage:
        """The agent on the screen."""
        ...

    def voiceless(self, action: Action) -> None:
        """Show the words of an action that could not be spoken, and that there is no voice."""

    def show_prompt(self, prompt: Prompt) -> None:
        """Show a prompt, and report its onset with ``ScreenOutput.shown``."""

    @property
    def holds_frames(self) -> bool:
        """True if a frame that is drawn early is not seen before it is due."""
        ...

    def show_frame(self, prompt: Prompt, frame: int, due: int) -> None:
        """Show a later frame of a prompt when it is ``due`` (ns), in a moment, and report its onset
        in the same way.
        """

    def show_typed(self, prompt: Prompt, text: str) -> None:
        """Show the text that the participant has typed so far in answer to a prompt."""

    def clear_prompt(self) -> None:
        """Remove the prompt."""

    def show_trial_feedback(self, feedback: TrialFeedback) -> None:
        """Show the answer to a trial, and report its onset with
        ``ScreenOutput.trial_feedback_shown``.
        """

    def begin_attempt(self, started: AttemptStarted) -> None:
        """Begin an attempt."""

    def marked(self, marked: TrialMarked) -> None:
        """Show the mark that a therapist gave a trial."""

    def progress(self, done: int) -> None:
        """Show the number of trials done in this attempt."""

    def end_attempt(self, ended: AttemptEnded) -> None:
        """End an attempt, which is scored."""

    def feedback_given(self, feedback: Feedback) -> None:
        """Show the result of an attempt, while the agent gives feedback on it."""

    def feedback_over(self) -> None:
        """Remove the results, because the agent says something else."""

    def wait(self, waiting: Waiting) -> None:
        """Show what the session waits for: Enter, a response, or a person."""

    def end(self, ended: SessionEnded) -> None:
        """Show the summary of an ended session."""


class ScreenOutput(OutputNode):
    """Shows the session's messages on a stage."""

    emits: ClassVar[tuple[Topic[Any], ...]] = (SHOWN, TRIAL_FEEDBACK_SHOWN, *OutputNode.emits)
    name = "screen"

    def __init__(self, stage: Stage, theme: Theme, *, shows_agent: bool = True) -> None:
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
            self._stage.voiceless(self._agent.action)

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

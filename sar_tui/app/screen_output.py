"""The screen as an output: what the loop says is put on a stage, and what becomes of it is reported back."""

from typing import Protocol

from sar_tui.framework.messages import (
    Action,
    AttemptEnded,
    AttemptStarted,
    OutputReport,
    Prompt,
    PromptVoided,
    ReachPerceived,
    SessionEnded,
    Shown,
    TrialEnded,
    TrialMarked,
    Waiting,
)
from sar_tui.framework.node import Node, on
from sar_tui.framework.topics import (
    ACTION,
    ATTEMPT_ENDED,
    ATTEMPT_STARTED,
    MARKED,
    PROMPT,
    REACH,
    REPORT,
    SESSION_ENDED,
    SHOWN,
    TRIAL,
    VOIDED,
    WAITING,
)


class Stage(Protocol):
    """What the session needs of a screen. The session screen is one; a test may bring another."""

    def show_prompt(self, prompt: Prompt) -> None:
        """Put a prompt up, and report its onset with ``ScreenOutput.shown``."""

    def clear_prompt(self) -> None:
        """Take the prompt away."""

    def begin_attempt(self, started: AttemptStarted) -> None:
        """An attempt begins: be quiet from here on."""

    def reached(self, reach: ReachPerceived) -> None:
        """A reach was seen; it may be shown when the attempt is over."""

    def marked(self, marked: TrialMarked) -> None:
        """A therapist marked a trial."""

    def progress(self, done: int) -> None:
        """So many trials of the attempt are done."""

    def end_attempt(self, ended: AttemptEnded) -> None:
        """An attempt is scored."""

    def say(self, action: Action) -> None:
        """The agent speaks: words and a face."""

    def wait(self, waiting: Waiting) -> None:
        """The session waits: for Enter, a response, or somebody."""

    def end(self, ended: SessionEnded) -> None:
        """The session is over."""


class ScreenOutput(Node):
    """Puts the loop's messages on a stage."""

    name = "screen"
    emits = (SHOWN, REPORT)

    def __init__(self, stage: Stage) -> None:
        super().__init__()
        self._stage = stage
        self._speaking: str | None = None

    @on(PROMPT)
    def prompted(self, prompt: Prompt) -> None:
        self._stage.show_prompt(prompt)

    def shown(self, shown: Shown) -> None:
        """The stage tells when a prompt reached the terminal; from any thread."""
        self.bus.post(SHOWN, shown)

    @on(REACH)
    def reach_perceived(self, reach: ReachPerceived) -> None:
        self._stage.reached(reach)

    @on(MARKED)
    def trial_marked(self, marked: TrialMarked) -> None:
        self._stage.marked(marked)

    @on(TRIAL)
    def trial_ended(self, trial: TrialEnded) -> None:
        self._stage.clear_prompt()
        self._stage.progress(trial.trial)

    @on(VOIDED)
    def voided(self, _: PromptVoided) -> None:
        self._stage.clear_prompt()

    @on(ATTEMPT_STARTED)
    def attempt_started(self, started: AttemptStarted) -> None:
        self._end_speaking()
        self._stage.begin_attempt(started)

    @on(ATTEMPT_ENDED)
    def attempt_ended(self, ended: AttemptEnded) -> None:
        self._stage.end_attempt(ended)

    @on(ACTION)
    def act(self, action: Action) -> None:
        self._end_speaking()
        self._stage.say(action)
        self._speaking = action.id
        self._report("started")

    @on(WAITING)
    def waiting(self, waiting: Waiting) -> None:
        if waiting.stage == "trial":
            self._end_speaking()
        self._stage.wait(waiting)

    @on(SESSION_ENDED)
    def session_ended(self, ended: SessionEnded) -> None:
        self._stage.end(ended)

    def _end_speaking(self) -> None:
        """Words stand until others take their place, or an attempt begins."""
        if self._speaking:
            self._report("done")
            self._speaking = None

    def _report(self, state: str) -> None:
        assert self._speaking
        report = OutputReport(action=self._speaking, output="screen", state=state, at=self.bus.clock.now())  # type: ignore[arg-type]
        self.bus.post(REPORT, report)

"""The agent on the screen as an output: draws actions on a stage, and reports when each began and
ended.
"""

from collections import deque
from collections.abc import Callable
from typing import Protocol

from msgspec.structs import replace

from sar_tui.loop.agent_state import AgentState, clears_words, step
from sar_tui.loop.clock import Handle
from sar_tui.model.gesture import Gesture
from sar_tui.model.messages import (
    Action,
    ActionPart,
    AgentActing,
    CueGiven,
    Message,
    OutputReport,
    Waiting,
)
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs.output import Output

READING, PER_WORD = 4 * SECOND, 600 * MS
"""Time in which a text is read by somebody who reads slowly: for any text, and for each word."""


class AgentStage(Protocol):
    """The screen of a drawn agent."""

    def say(
        self, text: str, face: str = "", valence: str | None = None, *, joins: bool = False
    ) -> None:
        """Show words and expression. Without words, those shown stay; ``joins`` adds to them."""

    def gesture(self, gesture: Gesture) -> None:
        """Begin a gesture of the drawn robot."""

    def gaze(self, where: str) -> None:
        """Let the drawn robot look somewhere (see `theme.GAZES`)."""

    def cue(self, gaze: str, gesture: Gesture | None) -> None:
        """Let the drawn robot look or point, in a single frame, while everything else is still."""

    def be_still(self) -> None:
        """Let the drawn robot rest at once."""

    def speaking(self, sounds: bool) -> None:
        """Move the mouth while a voice sounds."""

    def look(self, face: str) -> None:
        """Change the expression only."""

    def clear(self, face: str) -> None:
        """Remove the words."""

    def apply_theme(self, theme: Theme) -> None:
        """Use an edited theme from here on."""


class DrawnAgent(Output):
    """The agent on the screen: its face, words, gestures and gaze.

    Args:
        stage: the screen it is drawn on.
        is_shown: False if the screen is not one of the session's outputs, so that it is shown only
            if a voice fails.

    Attributes:
        state: what the agent shows.
    """

    name = "screen"

    def __init__(self, stage: AgentStage, *, is_shown: bool = True) -> None:
        self.can = frozenset(("show", "gesture", "gaze")) if is_shown else frozenset()
        self.action: Action
        self._stage = stage
        self.state = AgentState()
        self._shown = ""
        self._read_at = 0
        self._next: tuple[Action, Handle] | None = None
        self._gestures: deque[tuple[str, str]] = deque()
        self._moving: tuple[str, Handle] | None = None
        self._is_cueing = False

    def update(self, message: Message) -> None:
        """Follow a message, and draw the change of words, expression and mouth.

        An action is drawn part by part, as the output is asked for it.
        """
        before, self.state = self.state, step(self.state, message)
        if isinstance(message, Waiting) and message.stage == "paused":
            self._drop_next()
        if self._next and isinstance(message, OutputReport) and message.action == self._next[0].id:
            self._follow_voice(message)
        match message:
            case Waiting() if clears_words(before, message):
                self.clear()
                if before.words or before.face != self.state.face:
                    self._stage.clear(self.state.face)
            case Waiting() if before.face != self.state.face:
                self._stage.look(self.state.face)
            case OutputReport() if message.part == "say" and message.state != "queued":
                self._stage.speaking(self.state.is_speaking)
            case AgentActing() if before.is_speaking != self.state.is_speaking:
                self._stage.speaking(self.state.is_speaking)

    def cue(self, cue: CueGiven, do: Callable[[CueGiven], None]) -> None:
        """Draw a cue at once; ``do`` then requests its parts, which are reported as done."""
        self._is_cueing = True
        if self.can:
            self._stage.cue(cue.gaze, self.theme.gestures.get(cue.gesture))
        do(cue)
        self._is_cueing = False

    def apply_theme(self, theme: Theme) -> None:
        super().apply_theme(theme)
        self._stage.apply_theme(theme)

    def show(self, action: str, text: str, face: str) -> None:
        """Show words until others replace them, or a trial begins.

        Encouragement replaces feedback once that could be read, or when a voice says it: one
        thought at a time.
        """
        if text and self._shown and self.action.joins and self.action.kind == "encouragement":
            self._drop_next()
            self._next = (
                self.action,
                self.clock.call_at(max(self._read_at, self.clock.now()), self._show_next),
            )
            return
        if text or not self._shown:
            self.clear()
        self._say(self.action)
        if text or not self._shown:
            self._shown = action
        else:
            self.report(action, "show", "done")

    def _say(self, action: Action) -> None:
        self._stage.say(action.text, action.face, action.valence, joins=action.joins)
        begun = max(self._read_at, self.clock.now()) if action.joins else self.clock.now()
        self._read_at = begun + READING + PER_WORD * len(action.text.split())
        self.report(action.id, "show", "started")

    def _show_next(self) -> None:
        assert self._next
        (action, _), self._next = self._next, None
        self.clear()
        self._say(replace(action, joins=False))
        self._shown = action.id

    def _follow_voice(self, report: OutputReport) -> None:
        """Show the words that follow as soon as a voice says them, or cannot."""
        if self._next and report.part == "say" and report.state != "queued":
            self._next[1].cancel()
            self._show_next()

    def _drop_next(self) -> None:
        """Drop the words that have not been shown yet."""
        if self._next:
            (action, handle), self._next = self._next, None
            handle.cancel()
            self.report(action.id, "show", "aborted")

    def clear(self) -> None:
        """Report the words that were shown as done, and drop those that would follow."""
        self._drop_next()
        if self._shown:
            self.report(self._shown, "show", "done")
            self._shown = ""

    def gesture(self, action: str, name: str) -> None:
        """Perform gestures one after the other."""
        if self._is_cueing:
            self._report_done(action, "gesture")
            return
        self._gestures.append((action, name))
        if self._moving is None:
            self._move_on()

    def _move_on(self) -> None:
        while self._gestures and self._moving is None:
            action, name = self._gestures.popleft()
            gesture = self.theme.gestures.get(name)
            if gesture is None:
                self.report(action, "gesture", "failed", f"The theme has no gesture {name}.")
                continue
            self._stage.gesture(gesture)
            self.report(action, "gesture", "started")
            over = self.clock.now() + gesture.duration_ms * MS
            self._moving = (action, self.clock.call_at(over, self._moved))

    def _moved(self) -> None:
        assert self._moving
        action, _ = self._moving
        self._moving = None
        self.report(action, "gesture", "done")
        self._move_on()

    def gaze(self, action: str, where: str) -> None:
        if not self._is_cueing:
            self._stage.gaze(where)
        self._report_done(action, "gaze")

    def _report_done(self, action: str, part: ActionPart) -> None:
        self.report(action, part, "started")
        self.report(action, part, "done")

    def stop(self, action: str = "") -> None:
        """Abort gestures; words stay, but none follow."""
        if self._next and action in ("", self._next[0].id):
            self._drop_next()
        gone = [other for other, _ in self._gestures if action in ("", other)]
        self._gestures = deque(each for each in self._gestures if each[0] not in gone)
        if self._moving and action in ("", self._moving[0]):
            self._moving[1].cancel()
            gone.insert(0, self._moving[0])
            self._moving = None
            self._stage.be_still()
        elif not action:
            self._stage.be_still()
        for other in gone:
            self.report(other, "gesture", "aborted")
        self._move_on()

    def close(self) -> None:
        """Stop gestures, and report nothing more."""
        if self._moving:
            self._moving[1].cancel()
        if self._next:
            self._next[1].cancel()
        self._moving = self._next = None
        self._gestures.clear()
        self._shown = ""

"""The agent on the screen as an output: what it is asked to do is drawn on a stage, and reported back."""

from collections import deque
from collections.abc import Callable
from typing import Protocol

from sar_tui.framework.agent_state import AgentState, clears_words, step
from sar_tui.framework.clock import MS, Handle
from sar_tui.framework.gesture import Gesture
from sar_tui.framework.messages import Action, ActionPart, AgentActing, CueGiven, Message, OutputReport, Waiting
from sar_tui.framework.theme import Theme
from sar_tui.outputs.output import Output


class AgentStage(Protocol):
    """What a drawn agent needs of a screen."""

    def say(self, action: Action) -> None:
        """The agent's words and expression. Empty words leave those that stand; ``joins`` adds to them."""

    def gesture(self, gesture: Gesture) -> None:
        """The drawn robot moves through a gesture, beginning now."""

    def gaze(self, where: str) -> None:
        """The drawn robot looks somewhere (see `theme.GAZES`)."""

    def cue(self, gaze: str, gesture: Gesture | None) -> None:
        """The drawn robot looks or points, in a single frame, while everything else is still."""

    def be_still(self) -> None:
        """The drawn robot rests at once."""

    def speaking(self, sounds: bool) -> None:
        """A voice begins to sound, or has fallen silent: the mouth moves with it."""

    def look(self, face: str) -> None:
        """Change the expression only."""

    def clear_agent(self, face: str) -> None:
        """Take the words away."""

    def voiceless(self, action: Action, why: str) -> None:
        """What was to be heard could not be: its words have to be seen, and that it is so."""

    def apply_theme(self, theme: Theme) -> None:
        """The theme was edited: wear it from here on."""


class DrawnAgent(Output):
    """The agent on the screen: its face and words, its drawn gestures, where it looks.

    Args:
        stage: where it is drawn.
        is_shown: whether the screen is one of the session's outputs; else it is only seen where a voice fails.
    """

    name = "screen"

    def __init__(self, stage: AgentStage, *, is_shown: bool = True) -> None:
        self.can = frozenset(("show", "gesture", "gaze")) if is_shown else frozenset()
        self.action: Action
        self._stage = stage
        self.state = AgentState()
        self._shown = ""
        self._gestures: deque[tuple[str, str]] = deque()
        self._moving: tuple[str, Handle] | None = None
        self._is_cueing = False

    def update(self, message: Message) -> None:
        """Follow a message, and draw the change of words, expression and mouth.

        An action is drawn part by part, as the output is asked for it.
        """
        before, self.state = self.state, step(self.state, message)
        match message:
            case Waiting() if clears_words(before, message):
                self.clear()
                if before.words or before.face != self.state.face:
                    self._stage.clear_agent(self.state.face)
            case Waiting() if before.face != self.state.face:
                self._stage.look(self.state.face)
            case OutputReport() if message.part == "say" and message.state != "queued":
                self._stage.speaking(self.state.is_speaking)
            case AgentActing() if before.is_speaking != self.state.is_speaking:
                self._stage.speaking(self.state.is_speaking)

    def cue(self, cue: CueGiven, do: Callable[[CueGiven], None]) -> None:
        """Draw a cue at once; ``do`` asks for its parts, which with that are done."""
        self._is_cueing = True
        if self.can:
            self._stage.cue(cue.gaze, self.theme.gestures.get(cue.gesture))
        do(cue)
        self._is_cueing = False

    def apply_theme(self, theme: Theme) -> None:
        super().apply_theme(theme)
        self._stage.apply_theme(theme)

    def show(self, action: str, text: str, face: str) -> None:
        """Words stand until others take their place, or an attempt begins."""
        if text or not self._shown:
            self.clear()
        self._stage.say(self.action)
        self.report(action, "show", "started")
        if text or not self._shown:
            self._shown = action
        else:
            self.report(action, "show", "done")

    def clear(self) -> None:
        """Words that stood are gone."""
        if self._shown:
            self.report(self._shown, "show", "done")
            self._shown = ""

    def gesture(self, action: str, name: str) -> None:
        """One gesture after the other."""
        if self._is_cueing:
            self._did(action, "gesture")
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
        self._did(action, "gaze")

    def _did(self, action: str, part: ActionPart) -> None:
        self.report(action, part, "started")
        self.report(action, part, "done")

    def stop(self, action: str = "") -> None:
        """Gestures are broken off; words stay where they are."""
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
        """Tell nothing more."""
        if self._moving:
            self._moving[1].cancel()
        self._moving = None
        self._gestures.clear()
        self._shown = ""

"""The agent on a session's screen, and the notice that its voice has failed."""

from collections.abc import Callable, Sequence
from pathlib import Path

from textual.widget import Widget
from textual.widgets import Static

from sar_tui.loop.clock import Clock
from sar_tui.model.gesture import Gesture
from sar_tui.model.language import Language
from sar_tui.model.messages import Action
from sar_tui.model.theme import Theme
from sar_tui.widgets.agent import Agent


class SessionAgent:
    """The agent's stage (see `output.AgentStage`), and its two widgets, once they are made.

    The agent is shown if the screen is one of the session's outputs; otherwise only while its voice
    has failed, so that its words can be read.

    Args:
        cleared: called when the words are removed.

    Attributes:
        widget: the agent.
        notice: says at the top of the screen that there is no voice.
        words: the words that it shows.
    """

    widget: Agent
    notice: Static

    def __init__(self, cleared: Callable[[], None]) -> None:
        self._cleared = cleared
        self._is_voiceless = False
        self._shows_voiceless = False
        self.words = ""

    def make_widgets(
        self,
        theme: Theme,
        clock: Clock,
        tr: Language,
        *,
        is_shown: bool,
        picture: type[Widget] | None,
        folder: Path,
    ) -> None:
        """Make the widgets. For the arguments see `widgets.agent.Agent`.

        Args:
            is_shown: True if the screen is one of the session's outputs.
        """
        self.tr = tr
        self._is_shown = is_shown
        self.widget = Agent(theme, clock, picture, folder, id="agent")
        self.widget.display = is_shown
        self.notice = Static("", id="voice", markup=False)

    # --- what it is asked to do

    def say(
        self, text: str, face: str = "", valence: str | None = None, *, joins: bool = False
    ) -> None:
        if text:
            self.widget.note("")
            self.words = f"{self.words}\n{text}" if joins else text
        self.widget.say(text, face, valence, joins=joins)

    def leave_out(self, phrases: Sequence[str]) -> None:
        """Leave phrases out of the words on the screen; ``words`` keeps them."""
        self.widget.leave_out(phrases)

    def gesture(self, gesture: Gesture) -> None:
        self.widget.gesture(gesture)

    def gaze(self, where: str) -> None:
        self.widget.gaze(where)

    def cue(self, gaze: str, gesture: Gesture | None) -> None:
        self.widget.cue(gaze, gesture)

    def be_still(self) -> None:
        self.widget.be_still()

    def look(self, face: str) -> None:
        self.widget.look(face)

    def clear(self, face: str) -> None:
        self.words = ""
        self.widget.clear(face)
        self.widget.note("")
        self.widget.display = self._is_shown or self._shows_voiceless
        self._cleared()

    def apply_theme(self, theme: Theme) -> None:
        self.widget.apply_theme(theme)

    def ask(self, words: str) -> None:
        """Ask for something that must be read, even if the agent is otherwise hidden."""
        self.widget.display = True
        self.words = words
        self.widget.say(words, "listening")

    # --- its voice, and response windows

    def speaking(self, sounds: bool) -> None:
        if sounds:
            self._is_voiceless = False
            self._show_voice()
        self.widget.speaking(sounds)

    def voiceless(self, action: Action) -> None:
        """Show the words of an action that could not be spoken.

        The note below them is shown once; the notice stays until a voice sounds again.
        """
        was_voiceless, self._is_voiceless = self._is_voiceless, True
        if self.widget.is_held:
            return
        if not self._is_shown:
            self.say(action.text, action.face, action.valence, joins=action.joins)
        if not (was_voiceless and self._is_shown):
            self.widget.note(self.tr("The voice is silent; please read."))
        self._show_voice()

    def let_move(self, moves: bool) -> None:
        """Let the agent move, or hold it while a response is awaited; a change of its voice is
        shown after that.
        """
        if moves:
            self.widget.release()
            self._show_voice()
        else:
            self.widget.hold()

    def _show_voice(self) -> None:
        if self.widget.is_held or self._shows_voiceless == self._is_voiceless:
            return
        self._shows_voiceless = self._is_voiceless
        self.notice.update(self.tr("no voice") if self._is_voiceless else "")
        if self._is_voiceless:
            self.widget.display = True
        elif not self._is_shown:
            self.clear("neutral")

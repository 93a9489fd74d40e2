"""A screen with the agent on it, which also shows when its voice has failed."""

import dataclasses
import functools
from typing import Any

from textual.app import ComposeResult
from textual.widgets import Static

from sar_tui.app.live import LiveSession
from sar_tui.model.gesture import Gesture
from sar_tui.model.language import Language
from sar_tui.model.messages import Action
from sar_tui.model.theme import Theme
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.tui.language import session_language
from sar_tui.widgets.agent import Agent

_SCREEN = "screen"


class AgentScreen(DismissedOnce[None]):
    """The base of the session's screen: the agent's stage (see `output.AgentStage`).

    The agent is shown if the screen is one of the session's outputs; otherwise only while its voice
    has failed, so that its words can be read.
    """

    app: Any

    def __init__(self, live: LiveSession) -> None:
        super().__init__()
        self._live = live
        self._is_voiceless = False
        self._shows_voiceless = False

    @functools.cached_property
    def tr(self) -> Language:
        """Language of the session."""
        return session_language(self._live.run.session.task)

    @property
    def active_bindings(self) -> dict[str, Any]:
        """Bindings in the session's language; the stop key only if there is an output to stop."""
        others = [
            name for name in self._live.run.session.task.parameters.outputs if name != _SCREEN
        ]
        has_voice = any(name.partition(":")[0] in ("speech", "tones") for name in others)
        robot = self.tr("Stop robot")
        return {
            key: active._replace(
                binding=dataclasses.replace(
                    active.binding,
                    description=robot
                    if active.binding.id == "stop" and not has_voice
                    else self.tr(active.binding.description),
                    show=active.binding.show
                    and (bool(others) or active.binding.id != "stop")
                    and not (self.app.patient and active.binding.id == "quit"),
                )
            )
            for key, active in super().active_bindings.items()
        }

    def compose_voice(self) -> ComposeResult:
        """Compose the notice that there is no voice."""
        self._voice = Static("", id="voice", markup=False)
        yield self._voice

    def compose_agent(self) -> ComposeResult:
        """Compose the agent."""
        session = self._live.run.session
        self._shows_agent = _SCREEN in session.task.parameters.outputs
        folder = self.app.catalogue.theme_folder(session.theme.name)
        self.agent = Agent(session.theme, self._live.clock, self.app.picture, folder, id="agent")
        self.agent.display = self._shows_agent
        yield self.agent

    # --- the stage: what the agent is asked to do

    def say(self, action: Action) -> None:
        if action.text:
            self.agent.note("")
        self.agent.say(action.text, action.face, action.valence, joins=action.joins)

    def gesture(self, gesture: Gesture) -> None:
        self.agent.gesture(gesture)

    def gaze(self, where: str) -> None:
        self.agent.gaze(where)

    def cue(self, gaze: str, gesture: Gesture | None) -> None:
        self.agent.cue(gaze, gesture)

    def be_still(self) -> None:
        self.agent.be_still()

    def speaking(self, sounds: bool) -> None:
        if sounds:
            self._is_voiceless = False
            self._show_voice()
        self.agent.speaking(sounds)

    def look(self, face: str) -> None:
        self.agent.look(face)

    def voiceless(self, action: Action, why: str) -> None:
        """Show the note once; the notice at the top stays until a voice sounds again."""
        was_voiceless, self._is_voiceless = self._is_voiceless, True
        if self.agent.is_held:
            return
        if not self._shows_agent:
            self.say(action)
        if not (was_voiceless and self._shows_agent):
            self.agent.note(self.tr("The voice is silent; please read."))
        self._show_voice()

    def apply_theme(self, theme: Theme) -> None:
        self.agent.apply_theme(theme)

    # --- between and in trials

    def clear_agent(self, face: str) -> None:
        """Remove the words, as before a trial."""
        self.agent.clear(face)
        self.agent.note("")
        self.agent.display = self._shows_agent or self._shows_voiceless

    def ask(self, words: str) -> None:
        """Let the agent ask for something that must be read, even if it is otherwise hidden."""
        self.agent.display = True
        self.agent.say(words, "listening")

    def let_agent_move(self, moves: bool) -> None:
        """Let the agent move, or hold it while a response is awaited; a change of its voice is
        shown after that.
        """
        if moves:
            self.agent.release()
            self._show_voice()
        else:
            self.agent.hold()

    def _show_voice(self) -> None:
        if self.agent.is_held or self._shows_voiceless == self._is_voiceless:
            return
        self._shows_voiceless = self._is_voiceless
        self._voice.update(self.tr("no voice") if self._is_voiceless else "")
        if self._is_voiceless:
            self.agent.display = True
        elif not self._shows_agent:
            self.clear_agent("neutral")

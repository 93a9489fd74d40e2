"""The agent of a session elsewhere: shows what arrives over the link, as the participant's own
screen does.
"""

from collections.abc import Callable
from typing import Any, Protocol

from sar_tui.app.agent.output import AgentStage, DrawnAgent
from sar_tui.link.peer import Connection, Frame, PeerEvent, Welcome
from sar_tui.loop.agent_state import AgentState
from sar_tui.loop.clock import Clock, Handle
from sar_tui.loop.topics import ACTING, ACTION, CUE, HALT, REPORT, THEME, WAITING
from sar_tui.model.messages import (
    Action,
    AgentActing,
    CueGiven,
    Halt,
    OutputReport,
    ThemeApplied,
    Waiting,
)
from sar_tui.model.theme import Theme
from sar_tui.model.units import SECOND
from sar_tui.tui.web_driver import BrowserVoice

FRESH = 3 * SECOND
"""Actions older than this are shown as text, but no longer spoken or gestured: the view has just
joined.
"""
_VOICES = frozenset(("speech", "ros"))
"""Outputs that speak by themselves, and report when."""


class ViewScreen(Protocol):
    """The screen of the view."""

    @property
    def agent(self) -> AgentStage:
        """The agent on it."""
        ...

    def apply_theme(self, theme: Theme) -> None:
        """Use the colours of an edited theme."""

    def wait(self, waiting: Waiting) -> None:
        """Show what the session waits for: during a trial nothing moves, and no words are shown."""

    def connected(self, connection: Connection) -> None:
        """Show the state of the link."""

    def speak_language(self, code: str) -> None:
        """Use the session's language."""


class AgentView:
    """Follows the agent of a session.

    Args:
        screen: the screen it is drawn on.
        theme: used until the session's is known.
        clock: drives its motion.
        now: the session's clock (ns), to tell new actions from old ones.
        voice: also speaks the agent's words here.
    """

    def __init__(
        self,
        screen: ViewScreen,
        theme: Theme,
        clock: Clock,
        now: Callable[[], int],
        voice: BrowserVoice | None = None,
    ) -> None:
        self._screen = screen
        self._stage = screen.agent
        self._clock = clock
        self._now = now
        self._voice = voice
        self._drawn = DrawnAgent(screen.agent)
        self._drawn.open(theme, clock, lambda _: None)
        self._language = theme.language
        self._has_own_voice = False
        self._cleared = 0
        self._silence: Handle | None = None

    def receive(self, event: PeerEvent) -> None:
        """Handle an event of the link."""
        match event:
            case Welcome():
                self._enter(event)
            case Connection():
                self._connect(event)
            case list():
                for frame in event:
                    self._take(frame)

    def _enter(self, welcome: Welcome) -> None:
        outputs: list[Any] = list(welcome.parameters.get("outputs", ()))
        self._has_own_voice = any(str(name).partition(":")[0] in _VOICES for name in outputs)
        self._language = str(welcome.parameters.get("language", self._language))
        self._screen.speak_language(self._language)
        self._cleared = 0
        self._drawn.clear()
        self._drawn.state = AgentState()
        self._silence_voices()

    def _connect(self, connection: Connection) -> None:
        if connection.state != "connected":
            self._silence_voices()
            self._drawn.stop()
        self._screen.connected(connection)

    def _take(self, frame: Frame) -> None:
        is_fresh = self._now() - frame.at < FRESH
        match frame.message:
            case Action() if frame.topic is ACTION and frame.seq >= self._cleared:
                self._act(frame.message, is_fresh)
            case CueGiven() if frame.topic is CUE and is_fresh:
                self._drawn.cue(frame.message, lambda _: None)
            case Halt() if frame.topic is HALT and is_fresh:
                self._silence_voices()
                self._drawn.stop(frame.message.action)
            case ThemeApplied() if frame.topic is THEME:
                self._language = frame.message.theme.language
                self._drawn.apply_theme(frame.message.theme)
                self._screen.apply_theme(frame.message.theme)
            case OutputReport() if frame.topic is REPORT and (
                is_fresh or frame.message.state != "started"
            ):
                self._drawn.update(frame.message)
            case AgentActing() if frame.topic is ACTING:
                self._drawn.update(frame.message)
            case Waiting() if frame.topic is WAITING:
                self._wait(frame.message, frame.seq)

    def _act(self, action: Action, is_fresh: bool) -> None:
        self._drawn.action = action
        self._drawn.update(action)
        if action.text or action.face:
            self._drawn.show(action.id, action.text, action.face)
        if not is_fresh:
            return
        if action.gaze:
            self._drawn.gaze(action.id, action.gaze)
        if action.gesture:
            self._drawn.gesture(action.id, action.gesture)
        if action.spoken and self._voice:
            self._voice.say(action.spoken, self._language)
            if not self._has_own_voice:
                self._mouth(action.spoken)

    def _mouth(self, spoken: str) -> None:
        """Move the mouth for as long as the words take: a browser does not report when it has
        spoken.
        """
        voice = self._drawn.theme.voice
        seconds = len(spoken.split()) * 60 / voice.rate_in(self._language)
        if self._silence:
            self._silence.cancel()
        self._stage.speaking(True)
        self._silence = self._clock.call_at(
            self._clock.now() + round(seconds * SECOND), self._fall_silent
        )

    def _fall_silent(self) -> None:
        self._stage.speaking(self._drawn.state.is_speaking)

    def _wait(self, waiting: Waiting, seq: int) -> None:
        """Follow the session. Words that were said before a trial began are not shown any more."""
        if waiting.stage == "trial" and waiting.what != "agent":
            self._cleared = seq
        self._drawn.update(waiting)
        self._screen.wait(waiting)

    def _silence_voices(self) -> None:
        if self._silence:
            self._silence.cancel()
        self._drawn.state = self._drawn.state.silenced()
        self._stage.speaking(False)
        if self._voice:
            self._voice.hush()

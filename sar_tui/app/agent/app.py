"""The agent in a window of its own: its app, its screen, and the session it follows over the link."""

import asyncio
from collections.abc import Callable
from typing import Any

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.screen import Screen
from textual.widgets import Static

from sar_tui.app.agent.output import DrawnAgent
from sar_tui.link.peer import Connection, Frame, Peer, PeerEvent, PeerListener, Welcome
from sar_tui.loop.agent_state import AWAITED, AgentState
from sar_tui.loop.clock import Clock, Handle, LiveClock
from sar_tui.loop.topics import ACTING, ACTION, CUE, HALT, REPORT, THEME, WAITING
from sar_tui.model.language import Language
from sar_tui.model.messages import (
    Action,
    AgentActing,
    CueGiven,
    Halt,
    OutputReport,
    ThemeApplied,
    Waiting,
)
from sar_tui.model.theme import ENGLISH, Theme
from sar_tui.model.units import SECOND
from sar_tui.tui.base_app import DESIGN, BaseApp
from sar_tui.tui.language import app_language
from sar_tui.tui.web_driver import BrowserVoice
from sar_tui.widgets.agent import Agent

Join = Callable[[PeerListener, asyncio.AbstractEventLoop], Peer]
"""Joins a session's link; its events arrive on the loop's thread."""


class AgentApp(BaseApp):
    """Shows the agent of a session, and sends nothing.

    Args:
        theme: used until the session's is known.
        join: joins the session.
    """

    CSS_PATH = [DESIGN, "agent.tcss"]
    ENABLE_COMMAND_PALETTE = False

    def __init__(self, theme: Theme, join: Join) -> None:
        self.voice: BrowserVoice | None = None
        super().__init__()
        self._agent_theme = theme
        self.apply_theme(theme)
        self._join = join
        self._peer: Peer | None = None

    def on_mount(self) -> None:
        loop = asyncio.get_running_loop()
        clock = LiveClock(loop)
        self.run_worker(clock.run(), name="motion", group="motion")
        screen = AgentViewScreen(self._agent_theme, clock)
        self.push_screen(screen)
        self.view = AgentView(screen, self._agent_theme, clock, self._session_now, self.voice)
        self._peer = self._join(self.view.receive, loop)

    def _session_now(self) -> int:
        return self._peer.now() if self._peer else 0

    def on_unmount(self) -> None:
        if self._peer:
            self._peer.close()


class AgentViewScreen(Screen[None]):
    """The screen of `app.AgentView`. It shows the agent, and the state of the link.

    Args:
        theme: used until the session's is known.
        clock: drives the agent's motion.
    """

    app: Any
    AUTO_FOCUS = ""

    def __init__(self, theme: Theme, clock: Clock) -> None:
        super().__init__()
        self.tr: Language = app_language(ENGLISH)
        self.agent = Agent(theme, clock)
        self._status = Static(id="status", markup=False)
        self._connection = Connection("connecting")

    def compose(self) -> ComposeResult:
        with Vertical(id="stage"):
            yield self.agent
        yield self._status

    def on_mount(self) -> None:
        self.agent.look("sleeping")
        self._show_status()

    # --- what the view shows on it

    def apply_theme(self, theme: Theme) -> None:
        """Use the colours of an edited theme."""
        self.app.apply_theme(theme)

    def wait(self, waiting: Waiting) -> None:
        """Hold still while a response is awaited, as the participant's own screen does."""
        if self.agent.face == "sleeping" and waiting.stage != "paused":
            self.agent.look("listening")
        if waiting.stage == "trial" and waiting.what in AWAITED:
            self.agent.hold()
        else:
            self.agent.release()

    def connected(self, connection: Connection) -> None:
        self._connection = connection
        if connection.state != "connected":
            self.agent.release()
            self.agent.clear("sleeping")
        elif self.agent.face == "sleeping":
            self.agent.look("neutral")
        self._show_status()

    def speak_language(self, code: str) -> None:
        self.tr = app_language(code)
        self._show_status()

    def _show_status(self) -> None:
        """Show the state of the link, in words for participants."""
        match self._connection.state:
            case "connected":
                text = ""
            case "connecting":
                why = self._connection.why
                text = f"{self.tr('One moment…')}\n{why}" if why else self.tr("One moment…")
            case "lost":
                text = self.tr("The connection is lost; it comes back by itself.")
            case "ended":
                text = self.tr("The session is over. Thank you.")
        self._status.update(text)


FRESH = 3 * SECOND
"""Actions older than this are shown as text, but no longer spoken or gestured: the view has just
joined.
"""
_VOICES = frozenset(("speech", "ros", "ros4hri", "furhat", "reachy"))
"""Outputs that speak by themselves, and report when."""


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
        screen: AgentViewScreen,
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

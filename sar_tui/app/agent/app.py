"""The app that shows the agent alone."""

import asyncio
import os
from collections.abc import Callable
from typing import ClassVar

from textual.app import App
from textual.binding import Binding, BindingType

from sar_tui.app.agent.remote import AgentView
from sar_tui.app.agent.screen import AgentViewScreen
from sar_tui.framework.clock import LiveClock
from sar_tui.framework.theme import Theme
from sar_tui.link.peer import Peer, PeerListener
from sar_tui.tui.textual_theme import textual_theme
from sar_tui.tui.web_driver import BrowserVoice

INTERRUPTED = 130

Join = Callable[[PeerListener, asyncio.AbstractEventLoop], Peer]
"""Joins a session's link; what it tells is heard on the loop's thread."""


class AgentApp(App[int]):
    """Looks on, and acts on nothing.

    Args:
        theme: worn until the session tells its own.
        join: joins the session.
    """

    TITLE = "sar-tui"
    CSS_PATH = "agent.tcss"
    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+q", "quit", "Quit", priority=True),
        Binding("ctrl+c", "interrupt", "Stop", show=False, priority=True),
    ]

    def __init__(self, theme: Theme, join: Join) -> None:
        self.voice: BrowserVoice | None = None
        super().__init__()
        self.failure = ""
        self._agent_theme = theme
        self.wear(theme)
        self._join = join
        self._peer: Peer | None = None

    def on_mount(self) -> None:
        loop = asyncio.get_running_loop()
        clock = LiveClock(loop)
        self.run_worker(clock.run(), name="motion", group="motion")
        screen = AgentViewScreen(self._agent_theme, clock)
        self.push_screen(screen)
        self.view = AgentView(screen, self._agent_theme, clock, self._session_now, self.voice)
        self._peer = self._join(self.view.hear, loop)

    def wear(self, theme: Theme) -> None:
        """Have the colours of a theme."""
        anew = textual_theme(theme)
        self.register_theme(anew)
        if self.theme == anew.name:
            self.mutate_reactive(App.theme)
        else:
            self.theme = anew.name

    def _session_now(self) -> int:
        return self._peer.now() if self._peer else 0

    def on_unmount(self) -> None:
        if self._peer:
            self._peer.close()

    def action_interrupt(self) -> None:
        """Ctrl-C."""
        self.exit(return_code=INTERRUPTED)

    def _handle_exception(self, error: Exception) -> None:
        """A fault of ours: no traceback on anybody's screen, unless asked for."""
        if self.is_headless or os.environ.get("SAR_TUI_DEBUG"):
            super()._handle_exception(error)
            return
        self.failure = f"sar-tui failed ({type(error).__name__}: {error}). Set SAR_TUI_DEBUG=1 to see where."
        self._return_code = 1
        self._close_messages_no_wait()

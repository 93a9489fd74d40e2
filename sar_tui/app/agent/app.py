"""The app that shows the agent alone."""

import asyncio
from collections.abc import Callable

from sar_tui.app.agent.remote import AgentView
from sar_tui.app.agent.screen import AgentViewScreen
from sar_tui.link.peer import Peer, PeerListener
from sar_tui.loop.clock import LiveClock
from sar_tui.model.theme import Theme
from sar_tui.tui.base_app import BaseApp
from sar_tui.tui.web_driver import BrowserVoice

Join = Callable[[PeerListener, asyncio.AbstractEventLoop], Peer]
"""Joins a session's link; its events arrive on the loop's thread."""


class AgentApp(BaseApp):
    """Shows the agent of a session, and sends nothing.

    Args:
        theme: used until the session's is known.
        join: joins the session.
    """

    CSS_PATH = "agent.tcss"
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

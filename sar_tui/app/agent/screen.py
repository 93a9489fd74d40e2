"""The agent alone on a screen, large, to be seen from a distance."""

from typing import Any

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.screen import Screen
from textual.widgets import Static

from sar_tui.link.peer import Connection
from sar_tui.loop.agent_state import AWAITED
from sar_tui.loop.clock import Clock
from sar_tui.model.language import Language
from sar_tui.model.messages import Waiting
from sar_tui.model.theme import ENGLISH, Theme
from sar_tui.tui.language import app_language
from sar_tui.widgets.agent import Agent


class AgentViewScreen(Screen[None]):
    """The screen of `remote.AgentView`. It shows the agent, and the state of the link.

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

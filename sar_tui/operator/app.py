"""The operator's panel as an app of its own: in another terminal, on another machine, in a browser."""

import contextlib
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

from textual import events
from textual.app import App
from textual.binding import Binding, BindingType

from sar_tui.framework.messages import Role
from sar_tui.framework.theme import Theme
from sar_tui.link.discovery import JoinableSession, live_sessions
from sar_tui.link.invitation import Invitation
from sar_tui.operator.layout import PanelLayout
from sar_tui.operator.screen import PanelScreen
from sar_tui.operator.session_picker import ChooseScreen, panel
from sar_tui.tui.gc_control import SWITCH_INTERVAL
from sar_tui.tui.ordered_keys import in_order
from sar_tui.tui.textual_theme import textual_theme
from sar_tui.tui.timestamps import stamp_keys_as_read

INTERRUPTED = 130


class WizardApp(App[int]):
    """Joins a session, and shows its panel.

    Args:
        theme: is worn until the session's is known.
        folder: where the operator's own file is.
        name: of the operator, or observer.
        role: what they are.
        where: the session; without one, those that can be joined are shown.
        waits: without one, join the first that comes.
        look: finds those that can be joined.
    """

    TITLE = "sar-tui wizard"
    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+q", "quit", "Quit", priority=True),
        Binding("ctrl+c", "interrupt", "Stop", show=False, priority=True),
    ]

    def __init__(
        self,
        theme: Theme,
        folder: Path,
        name: str,
        role: Role = "operator",
        where: JoinableSession | Invitation | None = None,
        *,
        waits: bool = False,
        look: Callable[[], list[JoinableSession]] = live_sessions,
    ) -> None:
        super().__init__()
        self._theme, self._folder = theme, folder
        self._called, self._role = name, role
        self._where, self._waits, self._look = where, waits, look
        self.key_seconds = 0.0
        self.failure = ""

    def on_mount(self) -> None:
        self._wear(self._theme)
        if self._where:
            self._join(self._where)
        else:
            self.push_screen(ChooseScreen(waits=self._waits, look=self._look), self._join)

    def _join(self, where: JoinableSession | Invitation | None) -> None:
        if where is None:
            self.exit(return_code=0)
            return
        self.push_screen(self.make_panel(where), self._left)

    def _left(self, why: str | None) -> None:
        """The panel is left: by its key, or because there can be no link."""
        self.failure = why or ""
        self.exit(return_code=int(bool(why)))

    def make_panel(self, where: JoinableSession | Invitation) -> PanelScreen:
        """The panel of a session."""
        return panel(where, self._called, self._role, self._theme, self._folder)

    def on_board_themed(self, event: PanelLayout.Themed) -> None:
        """The operator sees the colours that the participant sees."""
        self._wear(event.theme)

    def _wear(self, theme: Theme) -> None:
        worn = textual_theme(theme)
        self.register_theme(worn)
        self.theme = worn.name

    async def on_event(self, event: events.Event) -> None:
        """An action is not told when its key was pressed."""
        if isinstance(event, events.Key):
            self.key_seconds = event.time
        if not await in_order(self, event):
            await super().on_event(event)

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


def run_wizard(app: WizardApp, tell: Callable[[str], object]) -> int:
    """Run it in this terminal, or browser; the exit code. ``tell``: is told why, if it could not go on."""
    stamp_keys_as_read()
    sys.setswitchinterval(SWITCH_INTERVAL)  # the link's thread has what a key does to send while the panel is drawn
    app.run()
    if app.failure:
        with contextlib.suppress(OSError):  # there may be nobody any more
            tell(app.failure)
    return app.return_code or int(bool(app.failure))

"""The operator's panel as an app of its own: in another terminal, on another machine, in a browser."""

import contextlib
from collections.abc import Callable
from pathlib import Path

from sar_tui.framework.messages import Role
from sar_tui.framework.theme import Theme
from sar_tui.link.discovery import JoinableSession, live_sessions
from sar_tui.link.invitation import Invitation
from sar_tui.operator.layout import PanelLayout
from sar_tui.operator.screen import PanelScreen
from sar_tui.operator.session_picker import ChooseScreen, panel
from sar_tui.tui.base_app import BaseApp


class WizardApp(BaseApp):
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

    def on_mount(self) -> None:
        self.apply_theme(self._theme)
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
        self.apply_theme(event.theme)


def run_wizard(app: WizardApp, report: Callable[[str], object]) -> int:
    """Run the panel in this terminal or browser; returns the exit code. ``report`` is called with why it failed."""
    code = app.run_here()
    if app.failure:
        with contextlib.suppress(OSError):  # the terminal may be gone
            report(app.failure)
    return code

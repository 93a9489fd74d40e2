"""The operator's panel as an app: in another terminal, on another machine, in a browser."""

import contextlib
from collections.abc import Callable
from pathlib import Path

from textual import on

from sar_tui.link.discovery import JoinableSession
from sar_tui.link.invitation import Invitation
from sar_tui.model.messages import Role
from sar_tui.model.theme import Theme
from sar_tui.operator.layout import PanelLayout
from sar_tui.operator.screen import PanelScreen
from sar_tui.operator.session_picker import ChooseScreen, panel
from sar_tui.tui.base_app import BaseApp


class WizardApp(BaseApp):
    """App that joins a session and shows its panel.

    Args:
        theme: applied until the session's theme is known.
        folder: the data folder, whose sessions can be joined; holds the operator's own file.
        name: the operator's or observer's name.
        role: operator or observer.
        where: the session; if None, the user chooses one.
        waits: join the first session that appears, if there is none yet.
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
    ) -> None:
        super().__init__()
        self._theme, self._folder = theme, folder
        self._user_name, self._role = name, role
        self._where, self._waits = where, waits

    def on_mount(self) -> None:
        self.apply_theme(self._theme)
        if self._where:
            self._join(self._where)
        else:
            self.push_screen(ChooseScreen(self._folder, waits=self._waits), self._join)

    def _join(self, where: JoinableSession | Invitation | None) -> None:
        if where is None:
            self.exit(return_code=0)
            return
        self.push_screen(self.make_panel(where), self._left)

    def _left(self, why: str | None) -> None:
        """Exit when the panel closes. ``why``: reason why no link could be made, if so."""
        self.failure = why or ""
        self.exit(return_code=int(bool(why)))

    def make_panel(self, where: JoinableSession | Invitation) -> PanelScreen:
        """Return the panel of a session."""
        return panel(where, self._user_name, self._role, self._theme, self._folder)

    @on(PanelLayout.Themed)
    def use_session_theme(self, event: PanelLayout.Themed) -> None:
        """Apply the colours that the participant sees."""
        self.apply_theme(event.theme)


def run_wizard(app: WizardApp, report: Callable[[str], object]) -> int:
    """Run the panel in this terminal or browser and return the exit code. ``report`` is called with
    the failure.
    """
    code = app.run_here()
    if app.failure:
        with contextlib.suppress(OSError):  # the terminal may be gone
            report(app.failure)
    return code

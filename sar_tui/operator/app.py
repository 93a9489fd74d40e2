"""The operator's panel as an app, in another terminal, on another machine or in a browser; and the
choice of the session to join.
"""

import asyncio
import contextlib
import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.screen import Screen
from textual.widgets import Static
from textual.widgets.option_list import Option

import sar_tui.loop
from sar_tui.drivers.login_name import login_name
from sar_tui.link import discovery
from sar_tui.link.client import Where, connect
from sar_tui.link.discovery import JoinableSession
from sar_tui.link.errors import LinkError
from sar_tui.link.invitation import Invitation
from sar_tui.link.visits import HomeFinder, HomeVisit
from sar_tui.model.language import Language, language
from sar_tui.model.messages import Role
from sar_tui.model.protocol import WizardProtocol
from sar_tui.model.theme import Theme
from sar_tui.operator.practice_log import times_practised
from sar_tui.operator.screen import PanelScreen
from sar_tui.store.interface_language import interface_language
from sar_tui.tui.base_app import BaseApp
from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.language import app_texts
from sar_tui.widgets.lists import OptionList

LOOK_SECONDS = 1.0
HOW_TO_START = "No session of this data folder can be joined. Start one with: {command}"
START_COMMAND = "sar-tui run TASK -p CODE --operator"


class WizardApp(BaseApp):
    """App that joins a session and shows its panel.

    Args:
        theme: applied until the session's theme is known.
        folder: the data folder, whose sessions can be joined; holds the operator's own file.
        name: the operator's or observer's name.
        role: operator or observer.
        where: the session; if None, the user chooses one; if an invitation to a router, a home.
        waits: join the first session that appears, if there is none yet.
        protocol: the operator's, if there is one.
    """

    TITLE = "sar-tui wizard"
    ENABLE_COMMAND_PALETTE = False

    def __init__(
        self,
        theme: Theme,
        folder: Path,
        name: str,
        role: Role = "operator",
        where: Where | None = None,
        *,
        waits: bool = False,
        protocol: WizardProtocol | None = None,
    ) -> None:
        super().__init__()
        self.tr = panel_texts(interface_language(folder))
        self._theme, self._folder = theme, folder
        self._user_name, self._role = name, role
        self._where, self._waits = where, waits
        self._protocol = protocol

    def on_mount(self) -> None:
        self.apply_theme(self._theme)
        self.begin()

    def begin(self) -> None:
        """Show the panel of the session, or the choice of one."""
        if isinstance(self._where, Invitation) and self._where.router:
            self.push_screen(HomesScreen(self._where, self.tr), self._join)
        elif self._where:
            self._join(self._where)
        else:
            self.push_screen(ChooseScreen(self._folder, self.tr, waits=self._waits), self._join)

    def _join(self, where: Where | None) -> None:
        if where is None:
            self.exit(return_code=0)
            return
        self.push_screen(self.make_panel(where), self._left)

    def _left(self, why: str | None) -> None:
        """Exit when the panel closes. ``why``: reason why no link could be made, if so."""
        self.failure = why or ""
        self.exit(return_code=int(bool(why)))

    def make_panel(self, where: Where) -> PanelScreen:
        """Return the panel of a session."""
        return panel(
            where,
            self._user_name,
            self._role,
            self._theme,
            self._folder,
            self.tr,
            self._protocol,
        )

    @on(PanelScreen.Themed)
    def use_session_theme(self, event: PanelScreen.Themed) -> None:
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


def own_name() -> str:
    """Return the default name of this user at a session."""
    return login_name() or "operator"


def panel(
    where: Where,
    name: str,
    role: Role,
    theme: Theme,
    folder: Path,
    tr: Language,
    protocol: WizardProtocol | None = None,
) -> PanelScreen:
    """Return the panel of a session. Called on the event loop that runs it."""
    join = functools.partial(connect, where, name, role, loop=asyncio.get_running_loop())
    practised = times_practised(folder, name, protocol) if protocol else 0
    return PanelScreen(join, theme, folder, tr=tr, protocol=protocol, practised=practised)


def panel_texts(code: str) -> Language:
    """Return the texts of the panel."""
    own = language(code, Path(sar_tui.loop.__file__).parent, Path(__file__).parent)
    return app_texts(code).including(own.texts)


class ChooseScreen(Screen[JoinableSession | None]):
    """List of a data folder's sessions that can be joined, updated every second.

    Args:
        folder: the data folder.
        tr: language of the panel.
        waits: join the first session that appears.
    """

    CSS = """
    ChooseScreen { align: center middle; }
    ChooseScreen #box { width: 70; height: auto; max-height: 80%; border: round $accent; padding: 0 1; }
    ChooseScreen #hint { width: 70; height: auto; margin: 1 0; color: $text-muted; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape", "leave", "Back")]

    app: Any

    def __init__(self, folder: Path, tr: Language, *, waits: bool = False) -> None:
        super().__init__()
        self.tr = tr
        self._folder, self._waits = folder, waits
        self._others: list[str] = []
        self._found: dict[str, JoinableSession] = {}

    @property
    def help_text(self) -> str:
        """Explanation of this screen in the help."""
        return f"{self.tr('The sessions of this data folder that an operator can join.')}\n"

    def compose(self) -> ComposeResult:
        box = OptionList(id="box", markup=False)
        box.border_title = self.tr("Sessions to join")
        yield box
        yield Static("", id="hint", markup=False)
        yield KeyFooter()

    def on_mount(self) -> None:
        self.look_again()
        self.set_interval(LOOK_SECONDS, self.look_again)

    def look_again(self) -> None:
        try:
            found = {live.session: live for live in discovery.joinable_sessions(self._folder)}
            others = discovery.other_folders(self._folder)
        except LinkError as error:
            self.query_one("#hint", Static).update(str(error))
            return
        if self._waits and len(found) == 1 and not self._found and self.is_active:
            self.dismiss(next(iter(found.values())))
            return
        if found != self._found or not found:
            self._found, self._others = found, others
            self._list()

    def _list(self) -> None:
        box = self.query_one("#box", OptionList)
        chosen = box.highlighted or 0
        box.clear_options()
        box.add_options(
            [
                Option(f"{live.description(self.tr)}   {live.session}", id=live.session)
                for live in self._found.values()
            ]
        )
        if self._found:
            box.highlighted = min(chosen, len(self._found) - 1)
        box.display = bool(self._found)
        self.query_one("#hint", Static).update(self._hint())

    def _hint(self) -> str:
        tr = self.tr
        if self._found:
            return tr("Enter joins.")
        hints = [tr(HOW_TO_START, command=START_COMMAND), tr("Waiting for one …")]
        if self._others:
            other = tr("There is a session of another data folder: {path}", path=self._others[0])
            hints.insert(1, other)
        return "\n\n".join(hints)

    @on(OptionList.OptionSelected, "#box")
    def _selected(self, event: OptionList.OptionSelected) -> None:
        self.dismiss(self._found[event.option.id or ""])

    def action_leave(self) -> None:
        self.dismiss(None)


class HomesScreen(Screen[HomeVisit | None]):
    """List of the homes where somebody is training, through a router.

    Args:
        invitation: of the operator or observer.
        tr: language of the panel.
    """

    CSS = """
    HomesScreen { align: center middle; }
    HomesScreen #box { width: 70; height: auto; max-height: 80%; border: round $accent; padding: 0 1; }
    HomesScreen #hint { width: 70; height: auto; margin: 1 0; color: $text-muted; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape", "leave", "Back")]

    app: Any

    def __init__(self, invitation: Invitation, tr: Language) -> None:
        super().__init__()
        self.tr = tr
        self._invitation = invitation
        self._finder = HomeFinder(invitation, self._changed)
        self._homes: tuple[str, ...] = ()

    @property
    def help_text(self) -> str:
        """Explanation of this screen in the help."""
        return f"{self.tr('The homes where somebody is training now. They are asked first.')}\n"

    def compose(self) -> ComposeResult:
        box = OptionList(id="box", markup=False)
        box.border_title = self.tr("Homes where somebody is training")
        yield box
        yield Static("", id="hint", markup=False)
        yield KeyFooter()

    def on_mount(self) -> None:
        self._finder.open()
        self.show()

    def on_unmount(self) -> None:
        self._finder.close()

    def _changed(self) -> None:
        """Called on the finder's threads."""
        with contextlib.suppress(RuntimeError):  # the app is closed
            self.app.call_later(self.show)

    def show(self) -> None:
        """Show the homes that are there, or why there are none."""
        box, tr, homes = self.query_one("#box", OptionList), self.tr, self._finder.homes
        if homes != self._homes:
            before = self._homes[box.highlighted] if box.highlighted is not None else ""
            self._homes = homes
            box.clear_options()
            box.add_options([Option(home, id=home) for home in homes])
            if homes:
                box.highlighted = homes.index(before) if before in homes else 0
                box.focus()
        box.display = bool(homes)
        nobody = f"{tr('Nobody is training at home now.')}\n\n{tr('Waiting for one …')}"
        hint = tr("Enter asks them whether you may watch.") if homes else nobody
        self.query_one("#hint", Static).update(tr(self._finder.why) if self._finder.why else hint)

    @on(OptionList.OptionSelected, "#box")
    def _selected(self, event: OptionList.OptionSelected) -> None:
        self.dismiss(HomeVisit(self._invitation, event.option.id or ""))

    def action_leave(self) -> None:
        self.dismiss(None)

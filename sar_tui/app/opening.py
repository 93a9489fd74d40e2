"""The opening of the app: the empty home screen is shown first, then filled. Keys pressed meanwhile
are kept.
"""

from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Any

from textual import events
from textual.screen import Screen

from sar_tui.app.screens.home import HomeScreen
from sar_tui.app.theming import ThemedApp
from sar_tui.plugins import Catalogue
from sar_tui.store.database import connect
from sar_tui.tui.gc_control import end_loading

if TYPE_CHECKING:
    from sar_tui.runs.plan import Plan


_LATEST_S = 1.0
"""Seconds after which the home screen is filled, whether its frame is known to be shown or not."""


class OpeningApp(ThemedApp):
    """The part of the app that opens its database, and its home screen in two steps.

    Args:
        folder: the data folder.
        catalogue: the installed tasks and themes.
        begin: a plan, or the id of an interrupted session, to begin in place of the home screen.

    Raises:
        StoreError, PluginError: the database cannot be opened, or no theme can be read.
    """

    _first_patient = ""
    today = staticmethod(date.today)
    """The date of the people in front of the screen."""

    def __init__(self, folder: Path, catalogue: Catalogue, begin: "Plan | str | None") -> None:
        super().__init__(catalogue)
        self.folder = folder
        self.database = connect(folder)
        self._begin = begin
        # input that waits until the home screen is filled; None from then on
        self._early_input: list[events.Event] | None = [] if self._opens_home else None

    @property
    def is_for_one_session(self) -> bool:
        """True if the app was opened for one session, and ends with it."""
        return self._begin is not None

    @property
    def _opens_home(self) -> bool:
        """True if the home screen is the first: no session and no patient mode begins at once."""
        return not (self.is_for_one_session or self._first_patient)

    def get_default_screen(self) -> Screen[Any]:
        """Return the screen below all others: the home screen, or nothing if the app is opened for
        something else.
        """
        return HomeScreen() if self._opens_home else super().get_default_screen()

    async def on_event(self, event: events.Event) -> None:
        """Handle an event; input waits until the home screen is filled, because an empty list would
        ignore it.
        """
        if self._early_input is not None and isinstance(event, (events.InputEvent, events.Paste)):
            self._early_input.append(event)
        else:
            await super().on_event(event)

    def on_ready(self) -> None:
        # called later, as one of the app's own messages: those that follow wait until it is done
        self.call_after_refresh(self.call_later, self._fill_home)
        # a screen that is removed takes along what waits for its refresh
        self.set_timer(_LATEST_S, self._fill_home)

    async def _fill_home(self) -> None:
        """Fill the home screen, now that its frame is shown; then handle the input that waited for
        it.
        """
        if self._early_input is None:
            return
        waiting, self._early_input = self._early_input, None
        home = self.screen_stack[0]
        assert isinstance(home, HomeScreen)
        await home.fill()
        end_loading()
        for event in waiting:
            await self.on_event(event)

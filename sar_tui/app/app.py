"""The app for participant and therapist: its keys, its terminal, and how it is opened."""

import contextlib
import functools
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from textual import events
from textual.app import SystemCommand
from textual.binding import Binding, BindingType
from textual.driver import Driver
from textual.screen import Screen
from textual.widget import Widget

from sar_tui.app.leaving import LeavingApp
from sar_tui.app.screen_keys import ScreenKeys
from sar_tui.loop.clock import host_now
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.runs.plugin_watchdog import PluginWatchdog
from sar_tui.theme_folder import may_have_images
from sar_tui.tui.terminal_input import PasteDropped, UnreadableInput
from sar_tui.tui.timestamps import OnsetWatch, watched
from sar_tui.tui.too_small import cover_if_too_small

if TYPE_CHECKING:  # loaded with a session, so that the first screen is there sooner
    from sar_tui.link.broker_process import BrokerProcess
    from sar_tui.loop.clock import Clock
    from sar_tui.runs.plan import Plan
    from sar_tui.widgets.prompt_pictures import Way

_KEY_NAMES = {"escape": "Esc", "question_mark": "?", "slash": "/", "delete": "Del"}


class SarTui(LeavingApp):
    """The app for participant and therapist: home, settings, sessions.

    Args:
        folder: the data folder.
        catalogue: the installed tasks and themes.
        begin: a plan, or the id of an interrupted session, to begin at once; then the app ends
            after it.
        clock: for tests: a clock that is advanced by hand.
        link: lets operators join the session; None if they cannot.
        patient: begin in patient mode, with this participant.
        markers: addresses to which each session's markers are sent.
        sync_flash: begin each session with a flash and a tone for cameras.

    Attributes:
        picture_way: how this terminal shows the pictures of prompts; None if it was not asked, or
            it cannot.
    """

    picture_way: "Way | None" = None
    CSS_PATH = "app.tcss"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("f2", "stop", "Stop voice", priority=True, id="stop"),
        Binding("f1", "help", "Help", id="help"),
        Binding("question_mark", "help", "Help", show=False, id="help-2"),
    ]

    def __init__(
        self,
        folder: Path,
        catalogue: Catalogue,
        begin: "Plan | str | None" = None,
        clock: "Clock | None" = None,
        link: "BrokerProcess | None" = None,
        patient: str = "",
        markers: Sequence[str] = (),
        sync_flash: bool = False,
    ) -> None:
        self.sync_flash = sync_flash
        self.onset_watch = OnsetWatch()
        self.screen_keys = ScreenKeys(
            lambda: host_now() / SECOND if clock is None else clock.now() / SECOND
        )
        super().__init__(
            folder, catalogue, begin, patient=patient, clock=clock, link=link, markers=markers
        )
        self.picture: type[Widget] | None = None
        self._has_begun = False

    def get_driver_class(self) -> type[Driver]:
        return watched(super().get_driver_class(), self.onset_watch, self._terminal_gone)

    async def on_mount(self) -> None:
        self.screen_change_signal.subscribe(self, self.screen_keys.changed, immediate=True)
        self.watch_themes()
        if self._first_patient:
            await self.begin_patient_mode(self._first_patient)
        elif self._begin is not None:
            self.begin_session(self._begin)
        self._has_begun = True
        cover_if_too_small(self, self.size)

    async def on_event(self, event: events.Event) -> None:
        """Drop keys that were meant for another screen."""
        if isinstance(event, events.Key) and not event.is_forwarded:
            at = event.time if self._session_clock is None else self._session_clock.now() / SECOND
            is_therapist = not self._has_participant
            if not self.screen_keys.pass_on(event, at, self.screen, is_therapist=is_therapist):
                return
        await super().on_event(event)

    # --- the stop key

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """The stop key works during a session; before and after, F2 is the screen's own."""
        return (
            self._open is not None if action == "stop" else super().check_action(action, parameters)
        )

    def action_stop(self) -> None:
        """F2, anywhere in a session: stop everything the agent says and does."""
        if self._open:
            from sar_tui.model.messages import SessionCommand

            asked = round(self._open.stamp(self.key_seconds) * SECOND)
            self._open.operate(SessionCommand(command="stop", at=asked))

    # --- the terminal

    def on_app_blur(self, event: events.AppBlur) -> None:
        self._focus_changed(False, event.time)

    def on_app_focus(self, event: events.AppFocus) -> None:
        self._focus_changed(True, event.time)

    def _focus_changed(self, focused: bool, seconds: float) -> None:
        if self._open:
            self._open.keyboard.focused(focused, self._open.stamp(seconds))

    def on_unreadable_input(self, message: UnreadableInput) -> None:
        """Record it in the session. Textual calls the base class's handler as well."""
        if self._open:
            self._open.keyboard.dropped(message.what, self._open.stamp(message.time))

    def on_paste_dropped(self, message: PasteDropped) -> None:
        """Record its length in the session, as that of any paste."""
        if self._open:
            self._open.keyboard.pasted(message.length, self._open.stamp(message.time))

    def on_resize(self, event: events.Resize) -> None:
        if self._has_begun:  # before, there is nothing to cover
            cover_if_too_small(self, event.size)

    # --- help

    def get_key_display(self, binding: Binding) -> str:
        """Return a key's name on the keyboard: "Ctrl-Q", "F1", "Esc"."""
        parts = binding.key.split("+")
        return binding.key_display or "-".join(
            _KEY_NAMES.get(part, part.capitalize()) for part in parts
        )

    def get_system_commands(self, screen: Screen[Any]) -> Iterable[SystemCommand]:
        """Fill the command palette."""
        yield SystemCommand("Help", "What this screen is for, and its keys", self.action_help)
        for name, theme in () if self._has_participant else self.themes.items():
            yield SystemCommand(
                f"Theme: {theme.title}", theme.summary, functools.partial(self.use_theme, name)
            )
        yield SystemCommand("Quit", "Leave sar-tui; a session under way is kept", self.action_quit)

    def action_help(self) -> None:
        from sar_tui.app.screens.help import HelpScreen

        if not isinstance(self.screen, HelpScreen):
            self.push_screen(HelpScreen(self.screen))


def find_picture_way(app: SarTui) -> None:
    """Ask the terminal how it shows pictures, if a task may have some. Before the app runs."""
    if app.catalogue.may_have_pictures():
        from sar_tui.widgets.prompt_pictures import find_way

        app.picture_way = find_way()


def run_app(
    folder: Path,
    catalogue: Catalogue,
    plan: "Plan | None" = None,
    resume: str | None = None,
    link: "BrokerProcess | None" = None,
    patient: str = "",
    markers: Sequence[str] = (),
    sync_flash: bool = False,
) -> int:
    """Run the app in this terminal; returns the exit code.

    Args:
        folder: the data folder.
        catalogue: the installed tasks and themes.
        plan: begin this session at once.
        resume: resume the interrupted session of this id at once.
        link: lets operators join that session; None if they cannot.
        patient: begin in patient mode, with this participant.
        markers: addresses to which each session's markers are sent.
        sync_flash: begin each session with a flash and a tone for cameras.

    Raises:
        StoreError, PluginError: before the app opens.
    """
    app = SarTui(
        folder,
        catalogue,
        plan or resume,
        link=link,
        patient=patient,
        markers=markers,
        sync_flash=sync_flash,
    )
    find_picture_way(app)
    if any(may_have_images(catalogue.theme_folder(name)) for name in catalogue.theme_names()):
        from sar_tui.widgets.picture import find_pictures

        app.picture = find_pictures()
    with PluginWatchdog(app.abandon):
        code = app.run_here()
    app.close_session()
    code = code or int(bool(app.failure or (app.live and (app.live.unsaved or app.live.rescued))))
    for line in app.exit_lines(code):
        with contextlib.suppress(OSError):  # the terminal may be gone
            print(line, file=sys.stderr)
    return code

"""The app: what holds the screens together, and what happens when the terminal, a signal or a fault ends it."""

import asyncio
import contextlib
import functools
import os
import signal
import sqlite3
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from textual import events
from textual.app import SystemCommand
from textual.binding import Binding, BindingType
from textual.driver import Driver
from textual.geometry import Size
from textual.screen import Screen
from textual.widget import Widget

from sar_tui.app.exit_message import INTERRUPTED, UNSAVED, say_last_words
from sar_tui.app.theming import ThemedApp
from sar_tui.framework.clock import SECOND, Clock, LiveClock
from sar_tui.framework.declaration import ParameterError
from sar_tui.framework.messages import Operator
from sar_tui.plugins import Catalogue, PluginError
from sar_tui.store.database import StoreError, connect, explain
from sar_tui.theme_folder import may_have_images
from sar_tui.tui.ordered_keys import in_order
from sar_tui.tui.timestamps import OnsetWatch, stamp_keys_as_read, watched
from sar_tui.tui.too_small import TooSmallScreen, is_too_small

if TYPE_CHECKING:  # what a session needs is loaded with the session: until then somebody waits for the first screen
    from sar_tui.app.live import LiveSession
    from sar_tui.inputs.feed import ImuFeed
    from sar_tui.link.broker_process import BrokerProcess
    from sar_tui.runs.plan import Plan


class SarTui(ThemedApp):
    """Home, settings, sessions.

    Args:
        folder: where data lives.
        catalogue: the tasks and themes there are.
        begin: a plan, or the id of an interrupted session, to begin with at once; then the app ends after it.
        clock: for tests: a clock to be advanced by hand.
        link: through which operators join the session, where they can.
    """

    TITLE = "sar-tui"
    CSS_PATH = "app.tcss"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+q", "quit", "Quit", priority=True, id="quit"),
        Binding("ctrl+c", "interrupt", "Stop", show=False, priority=True, id="interrupt"),
        Binding("f2", "stop", "Stop voice", priority=True, id="stop"),
        Binding("f1", "help", "Help", id="help"),
        Binding("question_mark", "help", "Help", show=False, id="help-2"),
    ]

    def __init__(
        self,
        folder: Path,
        catalogue: Catalogue,
        begin: "Plan | str | None" = None,
        clock: Clock | None = None,
        link: "BrokerProcess | None" = None,
    ) -> None:
        self.onset_watch = OnsetWatch()
        super().__init__(catalogue)
        self.folder = folder
        self.database = connect(folder)
        self.live: LiveSession | None = None
        self.feeds: Sequence[ImuFeed] = ()
        self.failure = ""
        self._begin = begin
        self._session_clock = clock
        self._link = link
        self.key_seconds = 0.0
        self.picture: type[Widget] | None = None

    def get_driver_class(self) -> type[Driver]:
        return watched(super().get_driver_class(), self.onset_watch, self._terminal_gone)

    @property
    def begins_at_once(self) -> bool:
        """Whether the app was opened for one session, and ends with it."""
        return self._begin is not None

    # --- beginning ----------------------------------------------------------------------------------------

    def on_mount(self) -> None:
        from sar_tui.app.screens.home import HomeScreen

        self._catch_signals()
        self.look_after_themes()
        if self._begin is None:
            self.push_screen(HomeScreen())
        else:
            self.begin_session(self._begin)
        self._check_room(self.size)

    def begin_session(self, what: "Plan | str") -> None:
        """Open a new or an interrupted session; say so if that cannot be. A new one's sensors are looked at first."""
        if self.is_web:
            self._cannot_begin("A session does not run in a browser, where nothing can be timed; run it in a terminal.")
            return
        if isinstance(what, str) or not what.task.sensor_seats(what.parameters):
            self._enter_session(what)
        else:
            self._check_sensors(what)

    def _check_sensors(self, plan: "Plan") -> None:
        """Start the sensors of a session, show what comes from them, and hand them over."""
        from sar_tui.app.screens.sensor_check import SensorCheckScreen
        from sar_tui.runs.sensors import open_sensors

        clock = self._session_clock or LiveClock(asyncio.get_running_loop())
        try:
            theme = self.catalogue.theme(plan.theme, plan.parameters.language)
            feeds = open_sensors(plan.task, plan.parameters, plan.seed, clock, self.folder)
        except (StoreError, PluginError, ParameterError) as error:
            self._cannot_begin(str(error))
            return
        self.feeds = feeds
        for feed in feeds:
            feed.start()
        self.clear_notifications()
        self._wear(theme, plan.parameters.language)
        screen = SensorCheckScreen(plan, feeds, clock)

        def checked(begins: bool | None) -> None:
            if begins:
                for sensor in screen.sensors:
                    if sensor.state == "ended":  # a recording that the session plays from its beginning
                        sensor.feed.stop()
                self._enter_session(plan, feeds)
            else:
                self._stop_feeds()
                if self.begins_at_once:
                    self.exit(return_code=0)
                else:
                    self._tell_what_waited()

        self.push_screen(screen, checked)

    def _stop_feeds(self) -> None:
        """Let go of sensors that no session has taken over."""
        for feed in self.feeds:
            feed.stop()
        self.feeds = ()

    def _enter_session(self, what: "Plan | str", feeds: "Sequence[ImuFeed]" = ()) -> None:
        """Open a session on a screen of its own."""
        from sar_tui.app.live import LiveSession
        from sar_tui.app.screens.session import SessionScreen
        from sar_tui.runs.plan import Failed

        live = LiveSession(self.folder, self.catalogue, self._session_clock, feeds, self._link)
        screen = SessionScreen(live)
        try:
            live.open(screen, what)
        except (StoreError, PluginError, ParameterError, Failed) as error:
            self._cannot_begin(str(error))
            return
        except sqlite3.Error as error:
            self._cannot_begin(str(explain(error)))
            return
        self.live, self.feeds = live, ()
        self.clear_notifications()
        session = live.run.session
        self._wear(session.theme, session.task.parameters.language)
        self.push_screen(screen, self._session_left)

    def _cannot_begin(self, why: str) -> None:
        self._stop_feeds()
        if self._begin is None:
            self.notify(why, severity="warning", timeout=15)
            self._tell_what_waited()
        else:
            self.failure = why
            self.exit(return_code=1)

    def _session_left(self, _: object) -> None:
        """The session's screen is gone: after its summary, or because the task failed."""
        self.close_session()
        self.look_for_edits(True)
        if self._begin is not None or self.failure:
            self.exit(return_code=1 if self.failure else 0)
            return
        self._tell_what_waited()
        if self.live and self.live.unsaved:
            self.notify(f"{UNSAVED} Free some space before the next session.", severity="error", timeout=30)

    def close_session(self) -> None:
        """Let go of sensors that are looked at, and of the live session, if there is one; end its workers."""
        self._stop_feeds()
        if self.live:
            self.live.close(self)

    # --- one stop ---------------------------------------------------------------------------------------------

    @property
    def _open(self) -> "LiveSession | None":
        """The session that has not been let go of."""
        return self.live if self.live and not self.live.is_closed else None

    @property
    def _seats_participant(self) -> bool:
        """Whether a participant sits there: in a session, or before one, while its sensors are looked at."""
        return self._open is not None or bool(self.feeds)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """The stop key is one while there is a session; before and after, it is a screen's own."""
        return self._open is not None if action == "stop" else super().check_action(action, parameters)

    async def on_event(self, event: events.Event) -> None:
        """An action is not told when its key was pressed."""
        if isinstance(event, events.Key):
            self.key_seconds = event.time
        if not await in_order(self, event):
            await super().on_event(event)

    def action_stop(self) -> None:
        """F2, anywhere in a session: everything the agent says and does."""
        if self._open:
            asked = round(self._open.stamp(self.key_seconds) * SECOND)
            self._open.operate(Operator(command="stop", at=asked))

    # --- the terminal --------------------------------------------------------------------------------------

    def on_app_blur(self, event: events.AppBlur) -> None:
        self._tell_focus(False, event.time)

    def on_app_focus(self, event: events.AppFocus) -> None:
        self._tell_focus(True, event.time)

    def _tell_focus(self, focused: bool, seconds: float) -> None:
        if self._open:
            self._open.keyboard.focused(focused, self._open.stamp(seconds))

    def on_resize(self, event: events.Resize) -> None:
        if len(self.screen_stack) > 1:  # before, there is nothing to cover
            self._check_room(event.size)

    def _check_room(self, size: Size) -> None:
        """Cover the screen while it has no room, and uncover it again.

        A cover that something stands over, such as the help, uncovers by itself when that is closed.
        """
        if not is_too_small(size):
            if isinstance(self.screen, TooSmallScreen):
                self.pop_screen()
        elif not any(isinstance(screen, TooSmallScreen) for screen in self.screen_stack):
            self.push_screen(TooSmallScreen())

    def _catch_signals(self) -> None:
        """A signal ends the app in order: the terminal restored, everything written."""
        if os.name != "posix" or self.is_headless:
            return
        loop = asyncio.get_running_loop()
        for name in ("SIGINT", "SIGTERM", "SIGHUP"):
            number = getattr(signal, name)
            loop.add_signal_handler(number, self.exit, None, 128 + number)

    def _terminal_gone(self) -> None:
        """Called from the writing thread."""
        self.call_later(self.exit, None, 128 + getattr(signal, "SIGHUP", 1))

    # --- ending ---------------------------------------------------------------------------------------------

    def exit(self, *args: Any, **how: Any) -> None:
        """Leave: devices are let go of while what they say to that can still be written down."""
        if self._open:
            self._open.let_go()
        super().exit(*args, **how)

    def action_interrupt(self) -> None:
        """Ctrl-C, anywhere."""
        self.exit(return_code=INTERRUPTED)

    def get_key_display(self, binding: Binding) -> str:
        """A key as it is called on the keyboard: "Ctrl-Q", "F1", "Esc"."""
        names = {"escape": "Esc", "question_mark": "?"}
        return "-".join(names.get(part, part.capitalize()) for part in binding.key.split("+"))

    def get_system_commands(self, screen: Screen[Any]) -> Iterable[SystemCommand]:
        """The command palette: few commands, all of them ours."""
        yield SystemCommand("Help", "What this screen is for, and its keys", self.action_help)
        for name, theme in () if self._seats_participant else self.themes.items():
            yield SystemCommand(f"Theme: {theme.title}", theme.summary, functools.partial(self.use_theme, name))
        yield SystemCommand("Quit", "Leave sar-tui; a session under way is kept", self.action_quit)

    def action_help(self) -> None:
        from sar_tui.app.screens.help import HelpScreen

        if not isinstance(self.screen, HelpScreen):
            self.push_screen(HelpScreen(self.screen))

    def _handle_exception(self, error: Exception) -> None:
        """A fault of ours: no traceback on anybody's screen, unless asked for."""
        if self.is_headless or os.environ.get("SAR_TUI_DEBUG"):
            super()._handle_exception(error)
            return
        self.failure = f"sar-tui failed ({type(error).__name__}: {error}). Set SAR_TUI_DEBUG=1 to see where."
        self._return_code = 1
        self._close_messages_no_wait()


def run_app(
    folder: Path,
    catalogue: Catalogue,
    plan: "Plan | None" = None,
    resume: str | None = None,
    link: "BrokerProcess | None" = None,
) -> int:
    """Run the app in this terminal; returns the exit code.

    Args:
        folder: where data lives.
        catalogue: the tasks and themes there are.
        plan: go straight into this session.
        resume: go straight on with the interrupted session of this id.
        link: through which operators join that session, where they can.

    Raises:
        StoreError, PluginError: before the app opens.
    """
    stamp_keys_as_read()
    app = SarTui(folder, catalogue, plan or resume, link=link)
    if any(may_have_images(catalogue.theme_folder(name)) for name in catalogue.theme_names()):
        from sar_tui.widgets.picture import find_pictures

        app.picture = find_pictures()
    app.run()
    app.close_session()
    code = app.return_code or int(bool(app.failure or (app.live and app.live.unsaved)))
    say_last_words(app, code)
    if app.untold:
        with contextlib.suppress(OSError):  # the terminal may be gone: then there is nobody to tell
            print(app.untold, file=sys.stderr)
    return code

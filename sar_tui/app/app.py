"""The participant's app: its screens, and its end by a key, a signal, a lost terminal or a fault."""

import asyncio
import contextlib
import functools
import os
import sqlite3
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

from sar_tui.app.exit_message import UNSAVED, exit_message
from sar_tui.app.patient_mode import PatientModeApp
from sar_tui.plugins import Catalogue, PluginError
from sar_tui.runs.plugin_watchdog import PluginWatchdog
from sar_tui.store.database import StoreError, connect, explain
from sar_tui.theme_folder import may_have_images
from sar_tui.tui.terminal_input import UnreadableInput
from sar_tui.tui.timestamps import OnsetWatch, watched
from sar_tui.tui.too_small import cover_if_too_small

if TYPE_CHECKING:  # loaded with a session, so that the first screen is there sooner
    from sar_tui.app.live import LiveSession
    from sar_tui.framework.clock import Clock
    from sar_tui.inputs.imu_feed import ImuFeed
    from sar_tui.link.broker_process import BrokerProcess
    from sar_tui.runs.plan import Plan

_UNNOTICED_SECONDS = 0.3
"""Longest wait for the disk at the end before the screen says so."""
_KEY_NAMES = {"escape": "Esc", "question_mark": "?", "slash": "/", "delete": "Del"}


class SarTui(PatientModeApp):
    """The app for participant and therapist: home, settings, sessions.

    Args:
        folder: the data folder.
        catalogue: the installed tasks and themes.
        begin: a plan, or the id of an interrupted session, to begin at once; then the app ends after it.
        clock: for tests: a clock that is advanced by hand.
        link: lets operators join the session; None if they cannot.
        patient: begin in patient mode, with this participant.
    """

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
    ) -> None:
        self.onset_watch = OnsetWatch()
        super().__init__(folder, catalogue, begin, patient=patient)
        self.live: LiveSession | None = None
        self.feeds: Sequence[ImuFeed] = ()
        self._is_leaving = False
        self._asked_since = ""
        self._is_asking = False
        self._session_clock = clock
        self._link = link
        self.picture: type[Widget] | None = None
        self._has_begun = False

    def get_driver_class(self) -> type[Driver]:
        return watched(super().get_driver_class(), self.onset_watch, self._terminal_gone)

    # --- beginning ----------------------------------------------------------------------------------------

    async def on_mount(self) -> None:
        self.watch_themes()
        if self._first_patient:
            await self.begin_patient_mode(self._first_patient)
        elif self._begin is not None:
            self.begin_session(self._begin)
        self._has_begun = True
        cover_if_too_small(self, self.size)

    def begin_session(self, what: "Plan | str") -> None:
        """Begin a new session (a plan) after a check of its sensors, or an interrupted one (its id)."""
        if self.is_web:
            self._cannot_begin("A session cannot run in a browser, where responses cannot be timed. Use a terminal.")
            return
        self._asked_since = ""
        if isinstance(what, str) or not what.parameters.ask_wellbeing:
            self._prepare_session(what)
        else:
            self._ask_before(what)

    def _ask_before(self, plan: "Plan") -> None:
        """Ask about pain and tiredness, and then begin the session, unless pain speaks against it."""
        from sar_tui.app import wellbeing
        from sar_tui.framework.declaration import ParameterError
        from sar_tui.runs.plan import Failed, set_up
        from sar_tui.store.wellbeing import now

        try:
            theme = self.catalogue.theme(plan.theme, plan.parameters.language)
            task = set_up(plan.task, plan.parameters)
        except (PluginError, ParameterError, Failed) as error:
            self._cannot_begin(str(error))
            return
        self._asked_since, self._is_asking = now(), True
        self._use(theme, plan.parameters.language)
        codes = [code for code in (plan.participant, plan.partner) if code]

        def answered(goes_on: bool | None) -> None:
            self._is_asking = False
            if goes_on:
                self._prepare_session(plan)
            else:
                self._not_begun()

        self.push_screen(wellbeing.ask_before(self, task, theme, codes), answered)

    def _not_begun(self) -> None:
        """Return to the home screen, or exit, because somebody decided not to begin."""
        if self.is_for_one_session:
            self.exit(return_code=0)
        else:
            self._show_pending_notice()

    def _prepare_session(self, what: "Plan | str") -> None:
        """Begin a session, after a check of its sensors if it is new."""
        if isinstance(what, str) or not what.task.sensor_seats(what.parameters):
            self._enter_session(what)
        else:
            self._check_sensors(what)

    def _check_sensors(self, plan: "Plan") -> None:
        """Start a session's sensors, show what they send, and hand them over to the session."""
        from sar_tui.app.screens.sensor_check import SensorCheckScreen
        from sar_tui.framework.clock import LiveClock
        from sar_tui.framework.declaration import ParameterError
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
        self._use(theme, plan.parameters.language)
        screen = SensorCheckScreen(plan, feeds, clock)

        def checked(begins: bool | None) -> None:
            if begins:
                for sensor in screen.sensors:
                    if sensor.state == "ended":  # a recording that the session plays from its beginning
                        sensor.feed.stop()
                self._enter_session(plan, feeds)
            else:
                self._stop_feeds()
                self._not_begun()

        self.push_screen(screen, checked)

    def _stop_feeds(self) -> None:
        """Stop sensors that no session has taken over."""
        for feed in self.feeds:
            feed.stop()
        self.feeds = ()

    def _enter_session(self, what: "Plan | str", feeds: "Sequence[ImuFeed]" = ()) -> None:
        """Open a session on a screen of its own."""
        from sar_tui.app.live import LiveSession
        from sar_tui.app.screens.session import SessionScreen
        from sar_tui.framework.declaration import ParameterError
        from sar_tui.runs.plan import Failed

        live = LiveSession(self.folder, self.catalogue, self._session_clock, feeds, self._link)
        screen = SessionScreen(live)
        try:
            live.open(screen, what)
        except (StoreError, PluginError, ParameterError, Failed) as error:
            self._cannot_begin(str(error), resumed=isinstance(what, str))
            return
        except sqlite3.Error as error:
            self._cannot_begin(str(explain(error)))
            return
        self.live, self.feeds = live, ()
        self._note_theme(live.run.theme_notice)
        if self._asked_since:
            from sar_tui.store import wellbeing

            with contextlib.suppress(StoreError):  # they stay with the participant
                wellbeing.attach(self.database, live.run.id, list(live.codes.values()), self._asked_since)
        self.clear_notifications()
        session = live.run.session
        self._use(session.theme, session.task.parameters.language)
        self.push_screen(screen, self._session_left)

    def _note_theme(self, notice: str) -> None:
        """Keep a notice on the session's theme for the therapist, until the participant has left."""
        if self.patient and notice:
            self.note_trouble(notice)
        elif notice:
            self.pending_notice = notice

    def _cannot_begin(self, why: str, *, resumed: bool = False) -> None:
        self._stop_feeds()
        if self.patient:
            self._exercise_cannot_begin(why, resumed=resumed)
        elif self._begin is None:
            self.notify(why, severity="warning", timeout=15)
            self._show_pending_notice()
        else:
            self.failure = why
            self.exit(return_code=1)

    def _session_left(self, _: object) -> None:
        """Close the session once its screen is gone: after its summary, or because the task failed."""
        self.close_session()
        self.look_for_edits(True)
        live = self.live
        if self.failure or live is None or not live.asks_after:
            self._return_home()
            return
        from sar_tui.app import wellbeing

        def answered(_: bool | None) -> None:
            self._is_asking = False
            self._return_home()
            for text in wellbeing.warnings(self, list(live.codes.values())):
                if self.patient:
                    self.note_trouble(text)
                else:
                    self.notify(text, severity="warning", timeout=60)

        self.check_database()
        self._is_asking = True
        self.push_screen(wellbeing.ask_after(self, live), answered)

    def _return_home(self) -> None:
        """Return to the home screen, or exit if the app was opened for one session."""
        if self.patient:
            self._patient_left()
            return
        if self._begin is not None or self.failure:
            self.exit(return_code=1 if self.failure else 0)
            return
        self._show_pending_notice()
        self.check_database()
        if self.live and self.live.rescued:
            self.notify(f"{self.live.rescued} `sar-tui rescue` brings it back.", severity="error", timeout=60)
        if self.live and self.live.unsaved:
            self.notify(f"{UNSAVED} Free some space before the next session.", severity="error", timeout=30)

    def _patient_left(self) -> None:
        """Keep what went wrong for the therapist, and go on to the participant's next exercise."""
        assert self.live
        if self.failure:
            self.note_trouble(self.failure)
            self.failure = ""
        if self.live.rescued:
            self.note_trouble(f"{self.live.rescued} `sar-tui rescue` brings it back.")
        if self.live.unsaved:
            self.note_trouble(UNSAVED)
        self.check_database()
        self._exercise_left(ended=self.live.run.session.ended)

    def close_session(self) -> None:
        """Close the live session and its workers, if there is one, and stop sensors that are being checked."""
        self._stop_feeds()
        if self.live:
            self.live.close(self)

    def check_database(self) -> None:
        """Open the database anew if its files were removed or replaced, and say so."""
        try:
            self.database.check()
        except StoreError as error:
            self.database.close()
            self.database = connect(self.folder)
            if self.patient:
                self.note_trouble(str(error))
            else:
                self.notify(str(error), severity="error", timeout=60)

    def tell_troubles(self) -> None:
        """Say if rescue files wait, or data was lost."""
        from sar_tui.store.troubles import troubles

        for text in troubles(self.database, self.folder):
            self.notify(text, severity="error", timeout=60)

    # --- the stop key -----------------------------------------------------------------------------------------

    @property
    def _open(self) -> "LiveSession | None":
        """The session that has not been closed."""
        return self.live if self.live and not self.live.is_closed else None

    @property
    def _has_participant(self) -> bool:
        """True during a session, while sensors are checked or questions asked around it, and in patient mode."""
        return self._open is not None or bool(self.feeds) or self._is_asking or bool(self.patient)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """The stop key works during a session; before and after, F2 is the screen's own."""
        return self._open is not None if action == "stop" else super().check_action(action, parameters)

    def action_stop(self) -> None:
        """F2, anywhere in a session: stop everything the agent says and does."""
        if self._open:
            from sar_tui.framework.clock import SECOND
            from sar_tui.framework.messages import SessionCommand

            asked = round(self._open.stamp(self.key_seconds) * SECOND)
            self._open.operate(SessionCommand(command="stop", at=asked))

    # --- quitting ---------------------------------------------------------------------------------------------

    async def action_quit(self) -> None:
        """Ctrl-Q: exit; during a session, ask first, because a participant may have pressed it by mistake.

        In patient mode a session is paused, and nothing else happens.
        """
        if self.patient:
            self.pause_session()
            return
        from sar_tui.app.screens.leave import LeaveScreen

        session = self._open.run.session if self._open else None
        if session is None or session.ended or session.broken:
            await super().action_quit()
        elif not any(isinstance(screen, LeaveScreen) for screen in self.screen_stack):
            in_trial = getattr(self.screen, "is_in_trial", False)
            answered = functools.partial(self._left_or_went_on, was_in_trial=in_trial)
            can_save = all(getattr(screen, "can_save", True) for screen in self.screen_stack)
            question = LeaveScreen(can_save=can_save)
            await self.push_screen(question, answered)  # mounted: the next key of a burst is its own

    def action_interrupt(self) -> None:
        """Ctrl-C: exit; in patient mode as Ctrl-Q."""
        if self.patient:
            self.pause_session()
        else:
            super().action_interrupt()

    def _left_or_went_on(self, leaves: bool | None, *, was_in_trial: bool) -> None:
        """Exit; or go on with the trial that the question has paused."""
        from sar_tui.framework.messages import SessionCommand
        from sar_tui.framework.session_phase import LEFT

        if leaves:
            if was_in_trial and self._open:
                self._open.operate(SessionCommand(command="pause", reason=LEFT))
            self.exit()
        elif was_in_trial and self._open:
            self._open.operate(SessionCommand(command="resume"))

    # --- the terminal --------------------------------------------------------------------------------------

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

    def on_resize(self, event: events.Resize) -> None:
        if self._has_begun:  # before, there is nothing to cover
            cover_if_too_small(self, event.size)

    def exit(self, *args: Any, **how: Any) -> None:
        """Exit, once the session is written. Until then the screen stays, so that nobody sees an empty terminal."""
        if self._is_leaving:
            return
        if self._open:
            self._open.stop(self)
            if not self._open.is_written(_UNNOTICED_SECONDS):
                self._is_leaving = True
                self.run_worker(self._exit_once_written(self._open, args, how), name="exit", group="exit")
                return
        super().exit(*args, **how)

    async def _exit_once_written(self, live: "LiveSession", args: Sequence[Any], how: dict[str, Any]) -> None:
        from sar_tui.app.live import LAST_WRITE_SECONDS
        from sar_tui.app.screens.saving import SavingScreen

        self.push_screen(SavingScreen())
        await asyncio.to_thread(live.is_written, LAST_WRITE_SECONDS)
        super().exit(*args, **how)

    def exit_lines(self, code: int) -> list[str]:
        """Return the lines to leave in the terminal."""
        tasks = self.catalogue.extra_tasks
        one = self.is_for_one_session
        lines = exit_message(code, self.failure, self.live, self.folder, tasks, names_ended_session=one)
        troubles = self._troubles if self.patient else ()  # nobody was there to be told
        return [*lines, *troubles, *filter(None, (self.pending_notice,))]

    def abandon(self, plugin: str) -> None:
        """End the program at once. For another thread, while this app's own hangs in the code of a plug-in."""
        if self._open:
            self._open.write_rest()
        with contextlib.suppress(Exception):  # the terminal may be gone
            if self._driver:
                self._driver.stop_application_mode()
                self._driver.close()
        self.failure = f"The {plugin} does not return from its own code. All earlier trials are kept."
        for line in self.exit_lines(1):
            with contextlib.suppress(OSError):
                print(line, file=sys.__stderr__, flush=True)
        os._exit(1)

    # --- help ------------------------------------------------------------------------------------------------

    def get_key_display(self, binding: Binding) -> str:
        """Return a key's name on the keyboard: "Ctrl-Q", "F1", "Esc"."""
        return "-".join(_KEY_NAMES.get(part, part.capitalize()) for part in binding.key.split("+"))

    def get_system_commands(self, screen: Screen[Any]) -> Iterable[SystemCommand]:
        """Fill the command palette."""
        yield SystemCommand("Help", "What this screen is for, and its keys", self.action_help)
        for name, theme in () if self._has_participant else self.themes.items():
            yield SystemCommand(f"Theme: {theme.title}", theme.summary, functools.partial(self.use_theme, name))
        yield SystemCommand("Quit", "Leave sar-tui; a session under way is kept", self.action_quit)

    def action_help(self) -> None:
        from sar_tui.app.screens.help import HelpScreen

        if not isinstance(self.screen, HelpScreen):
            self.push_screen(HelpScreen(self.screen))


def run_app(
    folder: Path,
    catalogue: Catalogue,
    plan: "Plan | None" = None,
    resume: str | None = None,
    link: "BrokerProcess | None" = None,
    patient: str = "",
) -> int:
    """Run the app in this terminal; returns the exit code.

    Args:
        folder: the data folder.
        catalogue: the installed tasks and themes.
        plan: begin this session at once.
        resume: resume the interrupted session of this id at once.
        link: lets operators join that session; None if they cannot.
        patient: begin in patient mode, with this participant.

    Raises:
        StoreError, PluginError: before the app opens.
    """
    app = SarTui(folder, catalogue, plan or resume, link=link, patient=patient)
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

"""The app for participant and therapist, from its first screen to the lines that it leaves in the
terminal.
"""

import contextlib
import functools
import sys
from collections.abc import Callable, Iterable, Sequence
from datetime import date, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from textual import events
from textual.app import SystemCommand
from textual.binding import Binding, BindingType
from textual.command import CommandPalette
from textual.driver import Driver
from textual.screen import Screen
from textual.widget import Widget

from sar_tui.app.leaving import UNSAVED, Leaving
from sar_tui.app.letters import AWAITED_SECONDS, Letters
from sar_tui.app.patient_mode import PatientMode
from sar_tui.app.read_aloud import REPEAT_KEY, ReadAloud
from sar_tui.app.screen_keys import ScreenKeys
from sar_tui.app.screens.home import HomeScreen
from sar_tui.app.themes import Themes
from sar_tui.loop.clock import host_now
from sar_tui.model.language import in_language
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.runs.plugin_watchdog import PluginWatchdog
from sar_tui.store.database import StoreError, connect
from sar_tui.store.interface_language import choose_interface_language, interface_language
from sar_tui.tui.base_app import DESIGN, BaseApp
from sar_tui.tui.gc_control import end_loading
from sar_tui.tui.terminal_input import PasteDropped, UnreadableInput
from sar_tui.tui.timestamps import OnsetWatch, watched
from sar_tui.tui.too_small import TooSmallScreen, cover_if_too_small
from sar_tui.widgets.language import app_texts, language_of

if TYPE_CHECKING:  # loaded with a session, so that the first screen is there sooner
    from sar_tui.app.live import LiveSession
    from sar_tui.app.screens.session import SessionScreen
    from sar_tui.app.session_start import SessionStart
    from sar_tui.app.switch import Switch
    from sar_tui.letterbox.exchange import Exchanged
    from sar_tui.link.broker_process import BrokerProcess
    from sar_tui.loop.clock import Clock
    from sar_tui.model.protocol import WizardProtocol
    from sar_tui.records.kind import Kind
    from sar_tui.rules.parameters import TaskParameters
    from sar_tui.runs.plan import Plan
    from sar_tui.store.forms import Occasion
    from sar_tui.store.records import Record
    from sar_tui.widgets.prompt_pictures import Way

_LATEST_S = 1.0
"""Seconds after which the home screen is filled, whether its frame is known to be shown or not."""
_LETTERS_SECONDS = 60.0
"""Letters are exchanged at this interval, too, for an app that is left open."""
_KEY_NAMES = {"escape": "Esc", "question_mark": "?", "slash": "/"}


class SarTui(BaseApp):
    """The app for participant and therapist: home, settings, sessions.

    Args:
        folder: the data folder.
        catalogue: the installed tasks and themes.
        begin: a plan, or the id of an interrupted session, to begin in place of the home screen;
            then the app ends after it. Or a function that shows something else.
        clock: for tests: a clock that is advanced by hand.
        link: lets operators join the session; None if they cannot.
        patient: begin in patient mode, with this participant.
        markers: addresses to which each session's markers are sent.
        sync_flash: begin each session with a flash and a tone for cameras.
        is_kept: False if the data folder is removed after the app.
        protocol: the operator's, for panels that are opened in the app.

    Attributes:
        tr: texts of the therapist's screens, those that have no language of their own.
        themes: those to choose from, and the one in use.
        patient_mode: lets a participant train alone.
        start: the last start of a session.
        live: the last session that was begun.
        leaving: ends the app.
        letters: exchanges letters, if there is a letterbox.
        aloud: reads the participant's screens aloud.
        screen_keys: judges which keys reach a screen.
        switch: of the participant; None if there is none.
        settings_drafts: values of settings that were left without saving, by participant and task.
        picture_way: how this terminal shows the pictures of prompts; None if it was not asked, or
            it cannot.

    Raises:
        StoreError, PluginError: the database cannot be opened, or no theme can be read.
    """

    picture_way: "Way | None" = None
    CSS_PATH = [DESIGN, "app.tcss"]
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("f12", "end_patient_mode", show=False, priority=True, id="end-patient-mode"),
        Binding("f2", "stop", "Stop voice", priority=True, id="stop"),
        Binding(REPEAT_KEY, "repeat", "Say again", priority=True, id="repeat"),
        Binding("f1", "help", "Help", id="help"),
        Binding("question_mark", "help", "Help", show=False, id="help-2"),
    ]
    today = staticmethod(date.today)
    """The date of the people in front of the screen."""
    hour = staticmethod(lambda: datetime.now().hour)
    """Their hour, 0 to 23."""

    def __init__(
        self,
        folder: Path,
        catalogue: Catalogue,
        begin: "Plan | str | Callable[[], None] | None" = None,
        clock: "Clock | None" = None,
        link: "BrokerProcess | None" = None,
        patient: str = "",
        markers: Sequence[str] = (),
        sync_flash: bool = False,
        is_kept: bool = True,
        protocol: "WizardProtocol | None" = None,
    ) -> None:
        self.sync_flash = sync_flash
        self.onset_watch = OnsetWatch()
        self.screen_keys = ScreenKeys(
            lambda: host_now() / SECOND if clock is None else clock.now() / SECOND
        )
        super().__init__()
        self.folder = folder
        self.is_kept = is_kept
        self.protocol = protocol
        self.catalogue = catalogue
        self.tr = app_texts(interface_language(folder))
        self.themes = Themes(self, catalogue)
        self.database = connect(folder)
        self.patient_mode = PatientMode(self, patient)
        self.leaving = Leaving(self)
        self.letters = Letters(folder, lambda done: self.call_later(self._letters_came, done))
        self.aloud = ReadAloud(self, clock)
        self.start: SessionStart | None = None
        self.live: LiveSession | None = None
        self.switch: Switch | None = None
        self.picture: type[Widget] | None = None
        self.settings_drafts: dict[tuple[str, str], dict[str, object]] = {}
        self._begin = begin
        self._first_patient = patient
        self._clock = clock
        self._link = link
        self._markers = markers
        self._told_of_letters: set[str] = set()
        self._is_asking = False
        self._has_begun = False
        # input that waits until the home screen is filled; None from then on
        self._early_input: list[events.Event] | None = [] if self._opens_home else None

    # --- state

    @property
    def is_for_one_session(self) -> bool:
        """True if the app was opened for one session, and ends with it."""
        return self._begin is not None

    @property
    def patient(self) -> str:
        """The participant who trains alone; empty if patient mode is off."""
        return self.patient_mode.participant

    @property
    def open_session(self) -> "LiveSession | None":
        """The session that has not been closed."""
        return self.live if self.live and not self.live.is_closed else None

    @property
    def has_participant(self) -> bool:
        """True during a session, while sensors are checked or questions asked around it, and in
        patient mode.
        """
        starts = self.start is not None and (self.start.is_asking or bool(self.start.feeds))
        return self.open_session is not None or starts or self._is_asking or bool(self.patient)

    # --- opening: the empty home screen is shown first, then filled

    @property
    def _opens_home(self) -> bool:
        """True if the home screen is the first: no session and no patient mode begins at once."""
        return not (self.is_for_one_session or self._first_patient)

    def get_default_screen(self) -> Screen[Any]:
        """Return the screen below all others: the home screen, or nothing if the app is opened for
        something else.
        """
        return HomeScreen() if self._opens_home else super().get_default_screen()

    def get_driver_class(self) -> type[Driver]:
        return watched(super().get_driver_class(), self.onset_watch, self._terminal_gone)

    async def on_mount(self) -> None:
        self.screen_change_signal.subscribe(self, self._screen_changed, immediate=True)
        self.themes.start_looking()
        if self._first_patient:
            await self.patient_mode.begin(self._first_patient)
        elif callable(self._begin):
            self._begin()
        elif self._begin is not None:
            self.begin_session(self._begin)
        self._has_begun = True
        if self._first_patient:
            self.call_after_refresh(self.exchange_letters)
        if self.letters.role:
            self.set_interval(_LETTERS_SECONDS, self.exchange_letters)
        cover_if_too_small(self, self.size)

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
        self.exchange_letters()
        for event in waiting:
            await self.on_event(event)

    async def on_event(self, event: events.Event) -> None:
        """Drop keys that were meant for another screen; let input wait until the home screen is
        filled, because an empty list would ignore it.
        """
        if isinstance(event, events.Key) and not event.is_forwarded:
            at = event.time if self._clock is None else self._clock.now() / SECOND
            is_therapist = not self.has_participant
            if self.switch and await self.switch.takes(event, at):
                return
            if not self.screen_keys.pass_on(event, at, self.screen, is_therapist=is_therapist):
                return
            if event.key != REPEAT_KEY:
                self.aloud.stop()
        if self._early_input is not None and isinstance(event, (events.InputEvent, events.Paste)):
            self._early_input.append(event)
        else:
            await super().on_event(event)

    def _screen_changed(self, screen: Screen[Any]) -> None:
        self.screen_keys.changed(screen)
        if self.switch:
            screen.call_after_refresh(self.look_for_choices)

    # --- a switch in place of the keys

    def use_switch(self, parameters: "TaskParameters | None", people: Sequence[str] = ()) -> None:
        """Use the switch of these people from here on, as it is set; None: the therapist is here."""
        self.screen_keys.set_bounce(parameters.bounce_ms if parameters else 0)
        if parameters and self.switch and self.switch.is_for(parameters, people):
            return
        if self.switch:
            self.switch.close()
            self.switch = None
        if parameters and parameters.switch != "none":
            from sar_tui.app.switch import Switch
            from sar_tui.rules.scanning import MOST
            from sar_tui.store import sessions

            press_times = sessions.press_times(self.database, people[0], MOST)
            self.switch = Switch(self, self._clock, parameters, people, press_times)
            self.look_for_choices()

    def _leave_switch(self) -> None:
        """Give the keys back to the therapist, unless a participant is alone here."""
        if not self.patient:
            self.use_switch(None)

    def look_for_choices(self) -> None:
        """Let the switch choose from what can be done now."""
        if self.switch:
            self.switch.look()

    async def take_key(self, event: events.Key) -> None:
        """Handle a key that the switch stands for."""
        self.screen_keys.changed(self.screen)
        self.aloud.stop()
        await super().on_event(event)

    # --- at home

    def use_language(self, code: str) -> None:
        """Use a language for the therapist's screens, from now on in this data folder."""
        try:
            choose_interface_language(self.folder, code)
        except OSError as error:
            self.notify(self.tr("It cannot be kept: {why}", why=str(error)), severity="warning")
        self.tr = app_texts(code)

    def check_database(self) -> None:
        """Open the database anew if its files were removed or replaced, and say so."""
        try:
            self.database.check()
        except StoreError as error:
            self.database.close()
            self.database = connect(self.folder)
            self._tell(in_language(error, self.tr), severity="error", timeout=60)

    def tell_troubles(self) -> None:
        """Say if rescue files wait, or data was lost."""
        from sar_tui.store.troubles import troubles

        for text in troubles(self.database, self.folder, self.tr):
            self.notify(text, severity="error", timeout=60)

    def _tell(self, text: str, **how: Any) -> None:
        """Notify the therapist, in patient mode once it ends."""
        if self.patient:
            self.patient_mode.note_trouble(text)
        else:
            self.notify(text, **how)

    # --- letters

    def exchange_letters(self) -> None:
        """Take letters, and send those that are due, unless a session is under way: nothing else
        may use the computer then.
        """
        if self.open_session is None:
            self.letters.begin()

    def await_letters(self) -> None:
        """Wait a moment for an exchange that is under way, because a session begins."""
        self.letters.wait(AWAITED_SECONDS)

    def _letters_came(self, done: "Exchanged | StoreError") -> None:
        """Show what has come, and say what went wrong."""
        if self.open_session is not None:
            return
        if isinstance(done, StoreError):
            self._tell_of_letters(in_language(done, self.tr))
            return
        for text in (*done.refused, *done.troubles):
            self._tell_of_letters(text)
        if done.taken and (came := getattr(self.screen, "letters_came", None)):
            came()

    def _tell_of_letters(self, text: str) -> None:
        """Tell the therapist once."""
        if text not in self._told_of_letters:
            self._told_of_letters.add(text)
            self._tell(text, severity="warning", timeout=30)

    # --- the beginning of a session

    def begin_session(self, what: "Plan | str") -> None:
        """Begin a new session (a plan) after a check of its sensors, or an interrupted one (its
        id).
        """
        if self.is_web:
            self.cannot_begin(
                self.tr(
                    "A session cannot run in a browser, where responses cannot be timed. Use a "
                    "terminal."
                )
            )
            return
        from sar_tui.app.session_start import SessionStart

        self.start = SessionStart(self, self._clock, self._link, self._markers)
        self.start.begin(what)

    def not_begun(self) -> None:
        """Return to the home screen, or exit, because somebody decided not to begin."""
        self._leave_switch()
        if self.is_for_one_session:
            self.exit(return_code=0)
        else:
            self._therapist_is_back()

    def _therapist_is_back(self) -> None:
        """Show what waited for the therapist, on the screen that a session was begun from."""
        if back := getattr(self.screen, "therapist_is_back", None):
            back()
        self.themes.show_pending_notice()

    def cannot_begin(self, why: str, *, resumed: bool = False, is_enough: bool = False) -> None:
        """Say why a session cannot begin; exit if the app was opened for it."""
        self._leave_switch()
        if self.patient:
            self.patient_mode.exercise_cannot_begin(why, resumed=resumed, is_enough=is_enough)
        elif self.is_for_one_session:
            self.failure = why
            self.exit(return_code=1)
        else:
            self.notify(why, severity="warning", timeout=15)
            self._therapist_is_back()

    def session_began(self, live: "LiveSession", screen: "SessionScreen") -> None:
        """Show a session that was opened."""
        self.live = live
        notice = live.run.theme_notice
        if self.patient and notice:
            self.patient_mode.note_trouble(notice)
        elif notice:  # waits for the therapist, until the participant has left
            self.themes.pending_notice = notice
        self.clear_notifications()
        session = live.session
        self.themes.use(session.theme, session.task.parameters.language)
        self.use_switch(session.task.parameters, list(live.codes.values()))
        self.aloud.use(session.task.parameters, session.theme, screen.tr)
        self.aloud.follow(session)
        self.push_screen(screen, self._session_left)

    # --- a form

    def fill_form(
        self,
        kind: "Kind",
        of: "Occasion",
        then: "Callable[[Record | None], None]",
        language: str = "",
    ) -> None:
        """Have a participant fill in a form, with the switch and the voice of their settings.

        Args:
            kind: the form (`store.forms.form`).
            of: who fills it in, and where it belongs.
            then: called with the record that is stored, or None if the form was left before it was
                complete; what is there goes on when it is filled in the next time on that day.
            language: of the form, if it is not that of the participant's settings.

        Raises:
            StoreError, PluginError, ParameterError: it cannot begin.
        """
        from sar_tui.app.forms import FormInterview, begin_form, form_language
        from sar_tui.app.screens.questions import QuestionScreen

        answers, parameters, name = begin_form(self.database, kind, of, language)
        theme = self.catalogue.theme(name, parameters.language)
        tr = form_language(parameters.language, theme.texts)

        def tell(text: str) -> None:
            self._tell(text, severity="error", timeout=30)

        interview = FormInterview(kind, answers, tr, tell)
        self.clear_notifications()
        self.themes.use(theme, parameters.language)
        self.use_switch(parameters, [of.participant])
        self.aloud.use(parameters, theme, tr)
        self._is_asking = True

        def filled(record: "Record | None") -> None:
            self._is_asking = False
            self._leave_switch()
            self.aloud.close()
            then(record)

        self.push_screen(QuestionScreen(interview), filled)

    # --- during a session

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """F2 stops during a session, F12 ends patient mode, and F9 says again what can be heard; else
        they are the screen's own.
        """
        if action == "stop":
            return self.open_session is not None
        if action == "end_patient_mode":
            return bool(self.patient)
        if action == "repeat":
            return self.aloud.is_on and bool(getattr(self.screen, "sentences", ()))
        return super().check_action(action, parameters)

    def action_stop(self) -> None:
        """F2, anywhere in a session: stop everything the agent says and does."""
        if live := self.open_session:
            from sar_tui.model.messages import SessionCommand

            asked = round(live.stamp(self.key_seconds) * SECOND)
            live.operate(SessionCommand(command="stop", at=asked))

    def action_repeat(self) -> None:
        """F9: read the screen aloud again."""
        self.aloud.repeat()

    def on_app_blur(self, event: events.AppBlur) -> None:
        self._focus_changed(False, event.time)

    def on_app_focus(self, event: events.AppFocus) -> None:
        self._focus_changed(True, event.time)

    def _focus_changed(self, focused: bool, seconds: float) -> None:
        if live := self.open_session:
            live.keyboard.focused(focused, live.stamp(seconds))

    def on_unreadable_input(self, message: UnreadableInput) -> None:
        """Record it in the session. Textual calls the base class's handler as well."""
        if live := self.open_session:
            live.keyboard.dropped(message.what, live.stamp(message.time))

    def on_paste_dropped(self, message: PasteDropped) -> None:
        """Record its length in the session, as that of any paste."""
        if live := self.open_session:
            live.keyboard.pasted(message.length, live.stamp(message.time))

    def on_resize(self, event: events.Resize) -> None:
        if self._has_begun:  # before, there is nothing to cover
            cover_if_too_small(self, event.size)
            if isinstance(self.screen, TooSmallScreen):
                self.aloud.read(self.screen)

    # --- after a session

    def _session_left(self, _: object) -> None:
        """Close the session once its screen is gone: after its summary, or because the task
        failed.
        """
        self.close_session()
        self.exchange_letters()
        self.themes.look_for_edits(True)
        live = self.live
        assert live
        if self.failure or not live.asks_after:
            self._return_from(live)
            return
        from sar_tui.app import wellbeing
        from sar_tui.app.screens.questions import QuestionScreen

        def answered(_: bool | None) -> None:
            self._is_asking = False
            self._return_from(live)
            for text in wellbeing.warnings(self, list(live.codes.values()), self.tr):
                self._tell(text, severity="warning", timeout=60)
            self.exchange_letters()

        self.check_database()
        self._is_asking = True
        self.push_screen(QuestionScreen(wellbeing.ask_after(self, live)), answered)

    def close_session(self) -> None:
        """Close the live session and its workers, if there is one, and stop sensors that are being
        checked.
        """
        if self.live:
            self.live.close(self)
            self.aloud.leave()
        if self.start:
            self.start.close()

    def _return_from(self, live: "LiveSession") -> None:
        """Return to the home screen or the next exercise, or exit if the app was opened for one
        session.
        """
        self._leave_switch()
        if self.patient:
            self._return_to_patient(live)
            return
        if self.is_for_one_session or self.failure:
            self.exit(return_code=1 if self.failure else 0)
            return
        self._therapist_is_back()
        self.check_database()
        if live.rescued:
            self.notify(self._rescued_text(live), severity="error", timeout=60)
        if live.unsaved:
            text = f"{self.tr(UNSAVED)} {self.tr('Free some space before the next session.')}"
            self.notify(text, severity="error", timeout=30)
        if live.trouble:
            self.notify(live.trouble, severity="error", timeout=30)
            live.trouble = ""

    def _rescued_text(self, live: "LiveSession") -> str:
        return f"{live.rescued} {self.tr('`sar-tui rescue` brings it back.')}"

    def _return_to_patient(self, live: "LiveSession") -> None:
        """Keep what went wrong for the therapist, and go on to the participant's next exercise."""
        note = self.patient_mode.note_trouble
        if self.failure:
            note(self.failure)
            self.failure = ""
        if live.rescued:
            note(self._rescued_text(live))
        if live.unsaved:
            note(self.tr(UNSAVED))
        if live.trouble:
            note(live.trouble)
        self.check_database()
        ended = live.session.ended
        self.patient_mode.exercise_left(ended=ended, is_mistake=live.is_mistake)
        from sar_tui.app import wellbeing

        if ended and wellbeing.had_better_rest(self, live):
            self.patient_mode.stopped_by_pain()

    # --- patient mode

    async def action_end_patient_mode(self) -> None:
        """F12: ask for the passphrase."""
        await self.patient_mode.ask_to_end()

    def catch_signals(self) -> None:
        super().catch_signals()
        if self.patient:
            self.patient_mode.hold_signals()

    def signalled(self, number: int) -> None:
        """End the app on a signal; in patient mode, only if it is not one that the terminal's keys
        send.
        """
        if not self.patient_mode.holds_back(number):
            super().signalled(number)

    # --- the end

    async def action_quit(self) -> None:
        """Ctrl-Q: exit; during a session, ask first. In patient mode a session is paused, and
        nothing else happens.
        """
        if self.patient:
            self.patient_mode.pause_session()
        elif not await self.leaving.ask():
            await super().action_quit()

    def action_interrupt(self) -> None:
        """Ctrl-C: exit, unless something is unsaved; in patient mode as Ctrl-Q."""
        if self.patient:
            self.patient_mode.pause_session()
        elif getattr(self.screen, "may_quit", lambda: True)():
            super().action_interrupt()

    def exit(self, *args: Any, **how: Any) -> None:
        """Exit, once the session is written."""
        self.leaving.leave(functools.partial(super().exit, *args, **how))

    def on_unmount(self) -> None:
        self.aloud.close()
        self.patient_mode.release_signals()

    # --- help

    def get_key_display(self, binding: Binding) -> str:
        """Return a key's name on the keyboard, in the language of the screen: "Ctrl-Q", "F1",
        "Esc".
        """
        tr = language_of(self)
        names = {"ctrl": tr("Ctrl"), "delete": tr("Del")}
        return binding.key_display or "-".join(
            names.get(part) or _KEY_NAMES.get(part, part.capitalize())
            for part in binding.key.split("+")
        )

    def get_system_commands(self, screen: Screen[Any]) -> Iterable[SystemCommand]:
        """Fill the command palette, in the language of the screen below it."""
        tr = language_of(self)
        about = tr("What this screen is for, and its keys")
        yield SystemCommand(tr("Help"), about, self.action_help)
        yield from getattr(screen, "commands", tuple)()
        for name in () if self.has_participant else self.themes.known:
            yield SystemCommand(
                tr("Theme: {name}", name=self.themes.title(name)),
                self.themes.summary(name),
                functools.partial(self.themes.use_named, name),
            )
        leave = tr("Leave sar-tui; a session under way is kept")
        yield SystemCommand(tr("Quit"), leave, self.action_quit)

    def action_command_palette(self) -> None:
        """Open the command palette."""
        if self.use_command_palette and not CommandPalette.is_open(self):  # type: ignore[arg-type]
            tr = language_of(self)
            asks = tr("Search for commands…")
            self.push_screen(CommandPalette(placeholder=asks, id="--command-palette"))

    def action_help(self) -> None:
        from sar_tui.app.screen_keys import HelpScreen

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
    what: "Plan | str | None" = None,
    link: "BrokerProcess | None" = None,
    patient: str = "",
    markers: Sequence[str] = (),
    sync_flash: bool = False,
    is_kept: bool = True,
    protocol: "WizardProtocol | None" = None,
) -> int:
    """Run the app in this terminal; returns the exit code.

    Args:
        folder: the data folder.
        catalogue: the installed tasks and themes.
        what: begin this session at once (a plan), or resume an interrupted one (its id).
        link: lets operators join that session; None if they cannot.
        patient: begin in patient mode, with this participant.
        markers: addresses to which each session's markers are sent.
        sync_flash: begin each session with a flash and a tone for cameras.
        is_kept: False if the data folder is removed after the app.
        protocol: the operator's, for panels that are opened in the app.

    Raises:
        StoreError, PluginError: before the app opens.
    """
    app = SarTui(
        folder,
        catalogue,
        what,
        link=link,
        patient=patient,
        markers=markers,
        sync_flash=sync_flash,
        is_kept=is_kept,
        protocol=protocol,
    )
    find_picture_way(app)
    if catalogue.may_have_faces():
        from sar_tui.widgets.agent import find_pictures

        app.picture = find_pictures()
    with PluginWatchdog(app.leaving.abandon):
        code = app.run_here()
    app.close_session()
    code = code or int(bool(app.failure or (app.live and (app.live.unsaved or app.live.rescued))))
    for line in app.leaving.lines(code):
        with contextlib.suppress(OSError):  # the terminal may be gone
            print(line, file=sys.stderr)
    app.letters.finish()
    return code


def run_form(
    folder: Path, catalogue: Catalogue, kind: "Kind", of: "Occasion", language: str = ""
) -> int:
    """Have a participant fill in a form in this terminal, and nothing else; returns the exit code.

    The arguments are those of `SarTui.fill_form`, and of `run_app`.

    Raises:
        StoreError, PluginError: before the app opens.
    """

    def begin() -> None:
        app.fill_form(kind, of, lambda _: app.exit(return_code=0), language)

    app = SarTui(folder, catalogue, begin)
    code = app.run_here()
    if app.failure:
        print(app.failure, file=sys.stderr)
    return code

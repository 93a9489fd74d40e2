"""The start of a session in the app: questions before it, the check of its sensors, its screen."""

import asyncio
import contextlib
import functools
import sqlite3
import time
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

import msgspec
from textual.app import ComposeResult
from textual.screen import ModalScreen
from textual.widgets import Static

from sar_tui.app.live import LiveSession, link_of
from sar_tui.app.prompt_needs import refusal
from sar_tui.app.screens.session import SessionScreen
from sar_tui.link.errors import LinkError
from sar_tui.loop.clock import Clock, LiveClock
from sar_tui.model.language import in_language
from sar_tui.plugins import PluginError
from sar_tui.rules.declaration import ParameterError
from sar_tui.runs.plan import EnoughToday, Failed, Plan, set_up
from sar_tui.store import records, sessions
from sar_tui.store.database import StoreError, explain
from sar_tui.store.training_days import utc
from sar_tui.tui.language import planned_language
from sar_tui.tui.timestamps import paint_now
from sar_tui.widgets.language import language_of

if TYPE_CHECKING:
    from sar_tui.app.app import SarTui
    from sar_tui.app.sensor_monitor import Calibration, SensorWatch
    from sar_tui.inputs.imu_feed import ImuFeed
    from sar_tui.link.broker_process import BrokerProcess

_SHOWN_AFTER_S = 1.0
"""A replay that takes longer shows its progress."""
_PAINTED_EVERY_S = 0.1


class SessionStart:
    """The start of one session.

    It ends in the app: ``session_began``, ``cannot_begin`` if something is missing, or
    ``not_begun`` if somebody decided so.

    Args:
        app: shows the session.
        clock: for tests: a clock that is advanced by hand.
        link: lets operators join the session; None if only its settings decide that.
        markers: addresses to which the session's markers are sent.

    Attributes:
        feeds: sensors that the session has not taken over yet.
        is_asking: True while the participant is asked about pain and tiredness.
    """

    def __init__(
        self,
        app: "SarTui",
        clock: Clock | None,
        link: "BrokerProcess | None",
        markers: Sequence[str],
    ) -> None:
        self._app = app
        self._clock = clock
        self._link = link
        self._own_link = contextlib.ExitStack()
        self._markers = markers
        self._asked_since = ""
        self.is_asking = False
        self.feeds: Sequence[ImuFeed] = ()

    def begin(self, what: Plan | str) -> None:
        """Begin a new session (a plan) after a check of its sensors, or an interrupted one (its
        id).
        """
        if isinstance(what, str):
            self._resume(what)
            return
        self._app.use_switch(what.parameters, what.participants)
        if what.parameters.ask_wellbeing:
            self._ask(what)
        else:
            self._prepare(what)

    def close(self) -> None:
        """Stop sensors that no session has taken over, and the session's own link."""
        self._stop_feeds()
        self._own_link.close()

    # --- a new session

    def _ask(self, plan: Plan) -> None:
        """Ask about pain and tiredness, and then begin the session, unless pain speaks against
        it.
        """
        from sar_tui.app.screens.questions import QuestionScreen
        from sar_tui.app.wellbeing import ask_before, warnings

        app = self._app
        try:
            theme = app.catalogue.theme(plan.theme, plan.parameters.language)
            task = set_up(plan.task, plan.parameters)
        except (PluginError, ParameterError, Failed) as error:
            self._refuse(in_language(error, self._app.tr))
            return
        self._asked_since, self.is_asking = utc(), True
        app.themes.use(theme, plan.parameters.language)
        app.aloud.use(plan.parameters, theme, planned_language(plan, app.catalogue))
        codes = list(plan.participants)

        def answered(goes_on: bool | None) -> None:
            self.is_asking = False
            for text in warnings(app, codes, app.tr) if app.patient else ():
                app.patient_mode.note_trouble(text)
            if goes_on:
                self._prepare(plan)
            else:
                if goes_on is False:
                    app.patient_mode.stopped_by_pain()
                app.not_begun()

        app.push_screen(QuestionScreen(ask_before(app, task, theme, codes)), answered)

    def _prepare(self, plan: Plan) -> None:
        """Begin a new session, after a check of its sensors if it has some."""
        if plan.task.sensor_seats(plan.parameters):
            self._check_sensors(plan)
        else:
            self._enter(plan)

    def _check_sensors(self, plan: Plan) -> None:
        """Start a session's sensors, show what they send, and hand them over to the session."""
        from sar_tui.app.screens.sensor_check import SensorCheckScreen
        from sar_tui.runs.sensors import open_sensors

        app = self._app
        clock = self._clock or LiveClock(asyncio.get_running_loop())
        try:
            theme = app.catalogue.theme(plan.theme, plan.parameters.language)
            feeds = open_sensors(plan.task, plan.parameters, plan.seed, clock, app.folder)
        except (StoreError, PluginError, ParameterError) as error:
            self._refuse(in_language(error, self._app.tr))
            return
        self.feeds = feeds
        for feed in feeds:
            feed.start()
        app.clear_notifications()
        app.themes.use(theme, plan.parameters.language)
        screen = SensorCheckScreen(plan, feeds, clock)
        self._recall_sensors(plan, screen.sensors)
        app.aloud.use(plan.parameters, theme, planned_language(plan, app.catalogue))

        def checked(begins: bool | None) -> None:
            if begins:
                for sensor in screen.sensors:
                    # a recording that the session plays from its beginning
                    if sensor.state == "ended":
                        sensor.feed.stop()
                self._enter(self._calibrated(plan, screen.calibration), feeds)
            else:
                self._stop_feeds()
                app.not_begun()

        app.push_screen(screen, checked)

    def _recall_sensors(self, plan: Plan, watches: "Sequence[SensorWatch]") -> None:
        """Tell each watch which sensor its participant wore last time."""
        from sar_tui.store.imu import last_sensors

        for watch in watches:
            code = plan.participants["AB".index(watch.feed.seat)]
            watch.before = last_sensors(self._app.database, code).get(watch.feed.part)

    def _calibrated(self, plan: Plan, made: "Calibration | None") -> Plan:
        """Return the plan with the least turn of a calibration, which is kept in the participant's
        programme.
        """
        from sar_tui.drivers.login_name import login_name
        from sar_tui.store import programmes

        if made is None:
            return plan
        own = {"least_turn_deg": made.least_turn_deg}
        turned = ", ".join(f"{degrees:.0f}°" for degrees in made.turned_deg)
        plan = msgspec.structs.replace(
            plan, parameters=msgspec.structs.replace(plan.parameters, **own)
        )
        database, code, task = self._app.database, plan.participant, plan.task.name
        try:
            self._app.letters.check_programme()
            last = programmes.newest(database, code, task)
            saved = programmes.save(
                database,
                code,
                task,
                programmes.Programme({**last.parameters, **own}, last.theme),
                after=last.version,
                author=login_name(),
                reason=f"Calibrated by reaches that turned the hand by {turned}.",
            )
        except StoreError as error:
            self._app.patient_mode.note_trouble(in_language(error, self._app.tr))
            return plan
        return msgspec.structs.replace(plan, programme=saved.version)

    def _stop_feeds(self) -> None:
        for feed in self.feeds:
            feed.stop()
        self.feeds = ()

    # --- an interrupted session

    def _resume(self, session_id: str) -> None:
        """Open an interrupted session, with the progress of its replay on the screen."""
        resuming = ResumingScreen()
        self._app.push_screen(resuming)
        enter = functools.partial(self._enter, session_id, resuming=resuming)
        resuming.call_after_refresh(self._app.call_later, enter)

    # --- the session's screen

    def _enter(
        self,
        what: Plan | str,
        feeds: "Sequence[ImuFeed]" = (),
        resuming: "ResumingScreen | None" = None,
    ) -> None:
        """Open a session on a screen of its own."""
        app = self._app
        app.await_letters()
        if not isinstance(what, str) and not what.id:
            what = msgspec.structs.replace(what, id=sessions.new_id())
        troubles: list[str] = []
        try:
            link = self._link or self._own_link.enter_context(
                link_of(what, app.database, app.folder, troubles.append)
            )
            refuse = functools.partial(refusal, no_color=app.no_color)
            live = LiveSession(
                app.folder, app.catalogue, self._clock, feeds, link, self._markers, refuse
            )
            screen = SessionScreen(live)
            with self._closed_after(resuming):
                live.open(screen.stage, what, resuming.show if resuming else None)
        except EnoughToday as error:
            self._refuse(in_language(error, self._app.tr), is_enough=True)
            return
        except (StoreError, PluginError, ParameterError, Failed, LinkError) as error:
            self._refuse(in_language(error, self._app.tr), resumed=isinstance(what, str))
            return
        except sqlite3.Error as error:
            self._refuse(in_language(explain(error), self._app.tr))
            return
        self.feeds = ()
        if app.patient:
            for text in troubles:
                app.patient_mode.note_trouble(text)
        else:
            live.trouble = " ".join(troubles)
        if self._asked_since:
            codes = list(live.codes.values())
            with contextlib.suppress(StoreError):  # they stay with the participant
                records.attach(app.database, live.run.id, codes, self._asked_since)
        app.session_began(live, screen)

    @contextlib.contextmanager
    def _closed_after(self, resuming: "ResumingScreen | None") -> Iterator[None]:
        """Close the screen of a replay after a block."""
        try:
            yield
        finally:
            if resuming:
                self._app.pop_screen()

    def _refuse(self, why: str, *, resumed: bool = False, is_enough: bool = False) -> None:
        self.close()
        self._app.cannot_begin(why, resumed=resumed, is_enough=is_enough)


class ResumingScreen(ModalScreen[None]):
    """Shows nothing at first, and the progress of a replay that takes longer than a moment.

    Args:
        now: returns the time in seconds.
    """

    DEFAULT_CSS = """
    ResumingScreen { align: center middle; background: transparent; }
    ResumingScreen #progress { width: auto; height: 1; min-width: 60; text-align: center; }
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self._now = now
        self._next_paint = now() + _SHOWN_AFTER_S

    def compose(self) -> ComposeResult:
        yield Static("", id="progress", markup=False)

    def show(self, done: int, of: int) -> None:
        """Show the progress at once, because nothing else is drawn during the replay."""
        if self._now() < self._next_paint:
            return
        self._next_paint = self._now() + _PAINTED_EVERY_S
        tr = language_of(self.app)
        line = self.query_one("#progress", Static)
        line.update(
            tr(
                "The session goes on where it stopped: {share} %",
                share=str(100 * done // max(1, of)),
            ),
            layout=False,
        )
        paint_now(line, in_place=True)

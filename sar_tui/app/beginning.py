"""The beginning of a session in the app: questions before it, the check of its sensors, its
screen.
"""

import asyncio
import contextlib
import functools
import sqlite3
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import msgspec

from sar_tui.app.patient_mode import PatientModeApp
from sar_tui.plugins import PluginError
from sar_tui.store.database import StoreError, explain

if TYPE_CHECKING:  # loaded with a session, so that the first screen is there sooner
    from sar_tui.app.live import LiveSession
    from sar_tui.app.screens.resuming import ResumingScreen
    from sar_tui.inputs.imu_feed import ImuFeed
    from sar_tui.link.broker_process import BrokerProcess
    from sar_tui.loop.clock import Clock
    from sar_tui.runs.plan import Plan


class BeginningApp(PatientModeApp):
    """The part of the app that begins sessions.

    Args:
        clock: for tests: a clock that is advanced by hand.
        link: lets operators join the session; None if they cannot.
        markers: addresses to which each session's markers are sent.

    Attributes:
        live: the last session that was begun.
        feeds: sensors that no session has taken over yet.
    """

    if TYPE_CHECKING:  # defined by the whole app

        def _session_left(self, _: object) -> None:
            """Close the session once its screen is gone."""

    def __init__(
        self,
        *args: Any,
        clock: "Clock | None" = None,
        link: "BrokerProcess | None" = None,
        markers: Sequence[str] = (),
        **how: Any,
    ) -> None:
        super().__init__(*args, **how)
        self.live: LiveSession | None = None
        self.feeds: Sequence[ImuFeed] = ()
        self._asked_since = ""
        self._is_asking = False
        self._session_clock = clock
        self._link = link
        self._markers = markers
        self._own_link = contextlib.ExitStack()

    @property
    def _open(self) -> "LiveSession | None":
        """The session that has not been closed."""
        return self.live if self.live and not self.live.is_closed else None

    @property
    def _has_participant(self) -> bool:
        """True during a session, while sensors are checked or questions asked around it, and in
        patient mode.
        """
        return self._open is not None or bool(self.feeds) or self._is_asking or bool(self.patient)

    def begin_session(self, what: "Plan | str") -> None:
        """Begin a new session (a plan) after a check of its sensors, or an interrupted one (its
        id).
        """
        if self.is_web:
            self._cannot_begin(
                "A session cannot run in a browser, where responses cannot be timed. Use a "
                "terminal."
            )
            return
        self._asked_since = ""
        if isinstance(what, str) or not what.parameters.ask_wellbeing:
            self._prepare_session(what)
        else:
            self._ask_before(what)

    def _ask_before(self, plan: "Plan") -> None:
        """Ask about pain and tiredness, and then begin the session, unless pain speaks against
        it.
        """
        from sar_tui.app import wellbeing
        from sar_tui.rules.declaration import ParameterError
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
        codes = list(plan.participants)

        def answered(goes_on: bool | None) -> None:
            self._is_asking = False
            for text in wellbeing.warnings(self, codes) if self.patient else ():
                self.note_trouble(text)
            if goes_on:
                self._prepare_session(plan)
            else:
                self._stopped_by_pain()
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
        if isinstance(what, str):
            self._resume(what)
        elif not what.task.sensor_seats(what.parameters):
            self._enter_session(what)
        else:
            self._check_sensors(what)

    def _check_sensors(self, plan: "Plan") -> None:
        """Start a session's sensors, show what they send, and hand them over to the session."""
        from sar_tui.app.screens.sensor_check import SensorCheckScreen
        from sar_tui.loop.clock import LiveClock
        from sar_tui.rules.declaration import ParameterError
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
                    # a recording that the session plays from its beginning
                    if sensor.state == "ended":
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

    def _resume(self, session_id: str) -> None:
        """Open an interrupted session, with the progress of its replay on the screen."""
        from sar_tui.app.screens.resuming import ResumingScreen

        resuming = ResumingScreen()
        self.push_screen(resuming)
        enter = functools.partial(self._enter_session, session_id, resuming=resuming)
        resuming.call_after_refresh(self.call_later, enter)

    def _enter_session(
        self,
        what: "Plan | str",
        feeds: "Sequence[ImuFeed]" = (),
        resuming: "ResumingScreen | None" = None,
    ) -> None:
        """Open a session on a screen of its own."""
        from sar_tui.app.live import LiveSession
        from sar_tui.app.prompt_needs import refusal
        from sar_tui.app.screens.session import SessionScreen
        from sar_tui.app.session_link import link_of
        from sar_tui.link.errors import LinkError
        from sar_tui.rules.declaration import ParameterError
        from sar_tui.runs.plan import EnoughToday, Failed
        from sar_tui.store.sessions import new_id

        if not isinstance(what, str) and not what.id:
            what = msgspec.structs.replace(what, id=new_id())
        try:
            link = self._link or self._own_link.enter_context(
                link_of(what, self.database, self.folder)
            )
            refuse = functools.partial(refusal, no_color=self.no_color)
            live = LiveSession(
                self.folder, self.catalogue, self._session_clock, feeds, link, self._markers, refuse
            )
            screen = SessionScreen(live)
            with self._closed_after(resuming):
                live.open(screen, what, resuming.show if resuming else None)
        except EnoughToday as error:
            self._cannot_begin(str(error), is_enough=True)
            return
        except (StoreError, PluginError, ParameterError, Failed, LinkError) as error:
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
                wellbeing.attach(
                    self.database, live.run.id, list(live.codes.values()), self._asked_since
                )
        self.clear_notifications()
        session = live.run.session
        self._use(session.theme, session.task.parameters.language)
        self.push_screen(screen, self._session_left)

    @contextlib.contextmanager
    def _closed_after(self, resuming: "ResumingScreen | None") -> Iterator[None]:
        """Close the screen of a replay after a block."""
        try:
            yield
        finally:
            if resuming:
                self.pop_screen()

    def _note_theme(self, notice: str) -> None:
        """Keep a notice on the session's theme for the therapist, until the participant has
        left.
        """
        if self.patient and notice:
            self.note_trouble(notice)
        elif notice:
            self.pending_notice = notice

    def _cannot_begin(self, why: str, *, resumed: bool = False, is_enough: bool = False) -> None:
        self._stop_feeds()
        self._own_link.close()
        if self.patient:
            self._exercise_cannot_begin(why, resumed=resumed, is_enough=is_enough)
        elif self._begin is None:
            self.notify(why, severity="warning", timeout=15)
            self._show_pending_notice()
        else:
            self.failure = why
            self.exit(return_code=1)

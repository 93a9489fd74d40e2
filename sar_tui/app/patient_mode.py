"""Patient mode: a participant trains alone, and only the passphrase leads to any other screen."""

import contextlib
import os
import signal
import sys
from typing import TYPE_CHECKING, Any, ClassVar

from textual.binding import Binding, BindingType

from sar_tui.app.opening import OpeningApp
from sar_tui.plugins import PluginError
from sar_tui.store.database import StoreError
from sar_tui.store.passphrase import Passphrase

if TYPE_CHECKING:
    from sar_tui.app.live import LiveSession
    from sar_tui.app.screens.patient import PatientScreen
    from sar_tui.runs.plan import Plan

_HELD_BACK = ("SIGTSTP", "SIGQUIT")
"""Signals that would show the shell, beside SIGINT and a SIGHUP whose terminal is still there."""


class PatientModeApp(OpeningApp):
    """The part of the app that keeps a participant to their own exercises.

    While ``patient`` is set, no key, palette, signal or resize leads to the first screen, the
    settings, another person or out of the app. A terminal that is gone, SIGTERM and SIGKILL still
    end it: see docs/patient-mode.md.

    Attributes:
        patient: code of the participant; empty if the mode is off.
        passphrase: ends the mode.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("f12", "end_patient_mode", show=False, priority=True, id="end-patient-mode")
    ]

    if TYPE_CHECKING:  # defined by the whole app

        @property
        def _open(self) -> "LiveSession | None":
            """The session that is open."""

    patient = ""

    def __init__(self, *args: Any, patient: str = "", **how: Any) -> None:
        self._first_patient = patient
        super().__init__(*args, **how)
        self.passphrase = Passphrase(self.folder)
        self._troubles: list[str] = []
        self._handlers: dict[int, Any] = {}
        self._patient_screen: PatientScreen | None = None
        if patient:
            self._hold(patient)

    # --- beginning and end

    def exercises_of(self, participant: str) -> list[str]:
        """Return the participant's exercises. Raises StoreError if there is none, or no passphrase
        is set.
        """
        from sar_tui.runs.patient_plan import exercises

        self.passphrase.keep()  # before the mode begins: without a passphrase it could not be ended
        try:
            return exercises(self.database, self.folder, self.catalogue, participant)
        except StoreError:
            self.passphrase.release()
            raise

    async def begin_patient_mode(self, participant: str) -> None:
        """Show only this participant's exercises from here on. Raises StoreError as
        `exercises_of`.
        """
        from sar_tui.app.screens.patient import PatientScreen

        found = self.exercises_of(participant)
        self._hold(participant)
        self._hold_signals()
        self.clear_notifications()
        self._patient_screen = PatientScreen(participant, found)
        await self.push_screen(self._patient_screen)

    def _hold(self, participant: str) -> None:
        self.patient = participant
        self.use_command_palette = False
        self.ENABLE_COMMAND_PALETTE = False  # type: ignore[misc]  # of this app: the footer asks it

    async def action_end_patient_mode(self) -> None:
        """F12: ask for the passphrase."""
        from sar_tui.app.screens.passphrase import PassphraseScreen

        if not any(isinstance(screen, PassphraseScreen) for screen in self.screen_stack):
            await self.push_screen(
                PassphraseScreen(self.passphrase, "patient mode"), self._passphrase_entered
            )

    def _passphrase_entered(self, is_right: bool | None) -> None:
        if not is_right or not self.patient:
            return
        self.patient = ""
        self.passphrase.release()
        self.use_command_palette = True
        self.ENABLE_COMMAND_PALETTE = True  # type: ignore[misc]
        self._release_signals()
        for text in self._troubles:
            self.notify(text, severity="warning", timeout=60)
        self._troubles.clear()
        self.refresh_bindings()
        self.call_later(self.leave_patient_screen)

    async def leave_patient_screen(self) -> None:
        """Show the first screen in place of the participant's, unless a session is on top of it."""
        from sar_tui.app.screens.home import HomeScreen

        if self.screen is not self._patient_screen:
            return
        self._patient_screen = None
        if any(isinstance(screen, HomeScreen) for screen in self.screen_stack):
            await self.pop_screen()
        else:
            await self.switch_screen(home := HomeScreen())
            await home.fill()

    # --- in the mode

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        return (
            bool(self.patient)
            if action == "end_patient_mode"
            else super().check_action(action, parameters)
        )

    def note_trouble(self, text: str) -> None:
        """Keep a message for the therapist until the mode ends; show it at once if it is off."""
        if not self.patient:
            self.notify(text, severity="warning", timeout=15)
        elif text not in self._troubles:
            self._troubles.append(text)

    def use_theme_of(self, plan: "Plan") -> None:
        """Use the theme of a planned session."""
        with contextlib.suppress(PluginError):
            self._use(
                self.catalogue.theme(plan.theme, plan.parameters.language), plan.parameters.language
            )

    def pause_session(self) -> None:
        """Pause the session, in place of leaving it."""
        from sar_tui.app.screens.session import SessionScreen

        if isinstance(self.screen, SessionScreen) and self.screen.check_action("pause", ()):
            self.screen.action_pause()

    def _exercise_left(self, *, ended: bool, is_mistake: bool) -> None:
        if self._patient_screen is not None and self.patient:
            self._patient_screen.session_left(ended=ended, is_mistake=is_mistake)

    def _exercise_cannot_begin(self, why: str, *, resumed: bool, is_enough: bool) -> None:
        self.note_trouble(why)
        if self._patient_screen is None:
            return
        if is_enough:
            self._patient_screen.enough_today()
        else:
            self._patient_screen.cannot_begin(resumed=resumed)

    def _stopped_by_pain(self) -> None:
        """Let the participant rest, who is in too much pain to begin, or to go on with the next
        exercise.
        """
        if self._patient_screen is not None and self.patient:
            self._patient_screen.stopped_by_pain()

    def on_unmount(self) -> None:
        self._release_signals()

    # --- signals

    def catch_signals(self) -> None:
        super().catch_signals()
        if self.patient:
            self._hold_signals()

    def signalled(self, number: int) -> None:
        """End the app on a signal; in the mode, only if it is not one that the terminal's keys
        send.
        """
        is_hang_up = number == getattr(signal, "SIGHUP", None)
        is_key = number in (signal.SIGINT, getattr(signal, "SIGQUIT", None))
        if self.patient and (is_key or (is_hang_up and _has_terminal())):
            return
        super().signalled(number)

    def _hold_signals(self) -> None:
        for name in _HELD_BACK:
            if (number := getattr(signal, name, None)) is not None:
                with contextlib.suppress(ValueError):  # not the main thread
                    before = signal.signal(number, signal.SIG_IGN)
                    if before is not signal.SIG_IGN:
                        self._handlers[number] = before

    def _release_signals(self) -> None:
        for number, handler in self._handlers.items():
            with contextlib.suppress(ValueError):
                signal.signal(number, handler)
        self._handlers.clear()


def ignore_keys_that_signal() -> None:
    """Ignore the signals of the terminal's keys while the program is loaded."""
    for name in ("SIGINT", *_HELD_BACK):
        if (number := getattr(signal, name, None)) is not None:
            signal.signal(number, signal.SIG_IGN)


def _has_terminal() -> bool:
    """Return True if the terminal has not hung up."""
    if os.name != "posix":
        return False
    import termios

    try:
        termios.tcgetattr(sys.__stdin__.fileno())  # type: ignore[union-attr]
    except (termios.error, OSError, ValueError, AttributeError):
        return False
    return True

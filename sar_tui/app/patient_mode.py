"""Patient mode: a participant trains alone, and only the passphrase leads to any other screen."""

import contextlib
import dataclasses
import os
import signal
import sys
from typing import TYPE_CHECKING, Any

from textual.binding import ActiveBinding

from sar_tui.store.database import StoreError
from sar_tui.store.passphrase import Passphrase

if TYPE_CHECKING:
    from sar_tui.app.app import SarTui
    from sar_tui.app.at_home import FromClinic
    from sar_tui.app.screens.patient import PatientScreen

_HELD_BACK = ("SIGTSTP", "SIGQUIT")
"""Signals that would show the shell, beside SIGINT and a SIGHUP whose terminal is still there."""


class PatientMode:
    """Keeps a participant to their own exercises.

    While there is a ``participant``, no key, palette, signal or resize leads to the first screen,
    the settings, another person or out of the app. A terminal that is gone, SIGTERM and SIGKILL
    still end it: see docs/patient-mode.md.

    Args:
        app: shows the participant's screen.
        participant: the mode is on from the start, with this participant.

    Attributes:
        participant: the code of who trains; empty if the mode is off.
        passphrase: ends the mode.
        troubles: messages for the therapist, kept until the mode ends.
    """

    def __init__(self, app: "SarTui", participant: str = "") -> None:
        self._app = app
        self.participant = ""
        self.passphrase = Passphrase(app.folder)
        self.troubles: list[str] = []
        self._handlers: dict[int, Any] = {}
        self._screen: PatientScreen | None = None
        if participant:
            self._hold(participant)

    # --- beginning and end

    async def begin(self, participant: str) -> None:
        """Show only this participant's exercises from here on. Raises StoreError as
        `exercises_of`.
        """
        from sar_tui.app.screens.patient import PatientScreen

        found = self.exercises_of(participant)
        self._hold(participant)
        self.hold_signals()
        self._app.clear_notifications()
        self._screen = PatientScreen(participant, found, self._from_clinic(participant))
        await self._app.push_screen(self._screen)

    def _from_clinic(self, participant: str) -> "FromClinic | None":
        """Return what comes from the clinic; None if this is no home."""
        letters = self._app.letters
        if letters.role != "home":
            return None
        from sar_tui.app.at_home import FromClinic

        return FromClinic(self._app, participant, letters)

    def exercises_of(self, participant: str) -> list[str]:
        """Return the participant's exercises. Raises StoreError if there is none, or no passphrase
        is set.
        """
        from sar_tui.runs.patient_plan import exercises

        app = self._app
        self.passphrase.keep()  # before the mode begins: without a passphrase it could not be ended
        try:
            return exercises(app.database, app.folder, app.catalogue, participant)
        except StoreError:
            self.passphrase.release()
            raise

    def _hold(self, participant: str) -> None:
        self.participant = participant
        self._offer_palette(False)

    def _offer_palette(self, offers: bool) -> None:
        self._app.use_command_palette = offers
        self._app.ENABLE_COMMAND_PALETTE = offers  # type: ignore[misc]  # the footer asks it

    async def ask_to_end(self) -> None:
        """Ask for the passphrase that ends the mode."""
        from sar_tui.app.screens.passphrase import PassphraseScreen

        if not any(isinstance(screen, PassphraseScreen) for screen in self._app.screen_stack):
            question = PassphraseScreen(self.passphrase, "patient mode")
            await self._app.push_screen(question, self._passphrase_entered)

    def _passphrase_entered(self, is_right: bool | None) -> None:
        if not is_right or not self.participant:
            return
        self.participant = ""
        self.passphrase.release()
        self._offer_palette(True)
        self.release_signals()
        for text in self.troubles:
            self._app.notify(text, severity="warning", timeout=60)
        self.troubles.clear()
        self._app.refresh_bindings()
        self._app.call_later(self.leave_screen)

    async def leave_screen(self) -> None:
        """Show the first screen in place of the participant's, unless a session is on top of it."""
        from sar_tui.app.screens.home import HomeScreen

        if self._app.screen is not self._screen:
            return
        self._screen = None
        if any(isinstance(screen, HomeScreen) for screen in self._app.screen_stack):
            await self._app.pop_screen()
        else:
            await self._app.switch_screen(home := HomeScreen())
            await home.fill()

    # --- in the mode

    def note_trouble(self, text: str) -> None:
        """Keep a message for the therapist until the mode ends; show it at once if it is off."""
        if not self.participant:
            self._app.notify(text, severity="warning", timeout=15)
        elif text not in self.troubles:
            self.troubles.append(text)

    def pause_session(self) -> None:
        """Pause the session, in place of leaving it."""
        from sar_tui.app.screens.session import SessionScreen

        screen = self._app.screen
        if isinstance(screen, SessionScreen) and screen.check_action("pause", ()):
            screen.action_pause()

    @property
    def next_exercise(self) -> tuple[int, int] | None:
        """Number of the exercise after the present one, and of all; None if there is none, or the
        mode is off.
        """
        return self._screen.next_exercise if self._screen is not None and self.participant else None

    def exercise_left(self, *, ended: bool, is_mistake: bool) -> None:
        """Go on to the next exercise after a session."""
        if self._screen is not None and self.participant:
            self._screen.session_left(ended=ended, is_mistake=is_mistake)

    def exercise_cannot_begin(self, why: str, *, resumed: bool, is_enough: bool) -> None:
        """Keep the reason for the therapist, and tell the participant what to do."""
        self.note_trouble(why)
        if self._screen is None:
            return
        if is_enough:
            self._screen.enough_today()
        else:
            self._screen.cannot_begin(resumed=resumed)

    def stopped_by_pain(self) -> None:
        """Let the participant rest, who is in too much pain to begin, or to go on with the next
        exercise.
        """
        if self._screen is not None and self.participant:
            self._screen.stopped_by_pain()

    # --- signals

    def holds_back(self, number: int) -> bool:
        """Return True if a signal must not end the app: the terminal's keys send it."""
        is_hang_up = number == getattr(signal, "SIGHUP", None)
        is_key = number in (signal.SIGINT, getattr(signal, "SIGQUIT", None))
        return bool(self.participant) and (is_key or (is_hang_up and _has_terminal()))

    def hold_signals(self) -> None:
        """Ignore signals that would show the shell."""
        for name in _HELD_BACK:
            if (number := getattr(signal, name, None)) is not None:
                with contextlib.suppress(ValueError):  # not the main thread
                    before = signal.signal(number, signal.SIG_IGN)
                    if before is not signal.SIG_IGN:
                        self._handlers[number] = before

    def release_signals(self) -> None:
        """Handle these signals as before."""
        for number, handler in self._handlers.items():
            with contextlib.suppress(ValueError):
                signal.signal(number, handler)
        self._handlers.clear()


def ignore_keys_that_signal() -> None:
    """Ignore the signals of the terminal's keys while the program is loaded."""
    for name in ("SIGINT", *_HELD_BACK):
        if (number := getattr(signal, name, None)) is not None:
            signal.signal(number, signal.SIG_IGN)


def keys_in_mode(app: Any, bindings: dict[str, ActiveBinding]) -> dict[str, ActiveBinding]:
    """Return a screen's bindings; in patient mode the key that leaves the app, which does nothing
    there, is hidden.
    """
    return {
        key: active._replace(binding=dataclasses.replace(active.binding, show=False))
        if app.patient and active.binding.id == "quit"
        else active
        for key, active in bindings.items()
    }


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

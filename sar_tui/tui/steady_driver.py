"""A driver for our apps: it ends in order on a signal, and keeps the terminal's answers to
itself.
"""

from textual import events
from textual.driver import Driver
from textual.message import Message

from sar_tui.tui.terminal_probe import TerminalProbe


def steady(driver: type[Driver], probe: TerminalProbe) -> type[Driver]:
    """Return a driver class that ends its app on a signal, and passes the terminal's answers to a
    probe.

    Args:
        driver: the class Textual chose.
        probe: asks the terminal.
    """

    class Steady(driver):  # type: ignore[valid-type, misc]
        def start_application_mode(self) -> None:
            """Catch signals before the terminal is changed, so that it is restored however early
            one comes.
            """
            self._app.catch_signals()
            super().start_application_mode()

        def stop_application_mode(self) -> None:
            if not self.is_web:
                probe.await_answers()
            super().stop_application_mode()

        def process_message(self, message: Message) -> None:
            """Note an answer, on the input thread."""
            if isinstance(message, events.CursorPosition):
                probe.answered()
            else:
                super().process_message(message)

    return Steady

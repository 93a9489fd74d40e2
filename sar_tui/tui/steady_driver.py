"""A driver for our apps that keeps the terminal's answers to itself."""

from textual import events
from textual.driver import Driver
from textual.message import Message

from sar_tui.tui.terminal_probe import TerminalProbe


def steady(driver: type[Driver], probe: TerminalProbe) -> type[Driver]:
    """Return a driver class that passes the terminal's answers to a probe.

    Args:
        driver: the class Textual chose.
        probe: asks the terminal.
    """

    class Steady(driver):  # type: ignore[valid-type, misc]
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

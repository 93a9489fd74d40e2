"""The last line about an error that nobody handled."""

import sqlite3
import threading
from typing import Any

import pytest
from textual.drivers.headless_driver import HeadlessDriver

from sar_tui.store.database import StoreError
from sar_tui.tui.base_app import BaseApp, explain_failure


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (StoreError("The disk is gone."), "The disk is gone."),
        (
            sqlite3.OperationalError("Could not decode to UTF-8 column 'a' with text"),
            "sar-tui.db is damaged. Restore",
        ),
        (ValueError("no"), "sar-tui failed (ValueError: no). Set SAR_TUI_DEBUG=1 to see where."),
    ],
)
def test_errors_of_the_database_are_sentences_already(error: Exception, said: str) -> None:
    assert explain_failure(error).startswith(said)


class Deaf(HeadlessDriver):
    """A driver whose terminal is lost while it is left, so that its input thread is never told to
    end.
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.exit_event = threading.Event()


class Lost(BaseApp):
    def get_driver_class(self) -> type[HeadlessDriver]:
        return Deaf

    def on_mount(self) -> None:
        self.exit()


def test_the_input_thread_ends_with_the_app_even_if_the_terminal_was_lost() -> None:
    app = Lost()
    assert app.run_here() == 0
    assert isinstance(app._driver, Deaf)
    assert app._driver.exit_event.is_set()

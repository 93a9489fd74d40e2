"""The last line about an error that nobody handled."""

import sqlite3

import pytest

from sar_tui.store.database import StoreError
from sar_tui.tui.base_app import explain_failure


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (StoreError("The disk is gone."), "The disk is gone."),
        (sqlite3.OperationalError("Could not decode to UTF-8 column 'a' with text"), "sar-tui.db is damaged. Restore"),
        (ValueError("no"), "sar-tui failed (ValueError: no). Set SAR_TUI_DEBUG=1 to see where."),
    ],
)
def test_errors_of_the_database_are_sentences_already(error: Exception, said: str) -> None:
    assert explain_failure(error).startswith(said)

"""Participants: pseudonymous codes."""

import re
import sqlite3
from datetime import UTC, datetime

from sar_tui.store.database import StoreError, transaction

_CODE = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,31}")


def check_code(code: str) -> str:
    """Return a code as it is stored, in capital letters. Raise StoreError if it is not valid."""
    code = code.strip()
    if not _CODE.fullmatch(code):  # before the capitals: those of ß and ı are letters of other codes
        raise StoreError(
            "A participant code has 1 to 32 letters, digits, - or _, and begins with a letter or digit, such as P01. "
            "Never use a name.",
            bad_input=True,
        )
    return code.upper()


def add(db: sqlite3.Connection, code: str) -> str:
    """Add a participant unless they are known, and return the code as it is stored.

    Raises:
        StoreError: the code is not valid, or the disk cannot write.
    """
    code = check_code(code)
    row = (code, datetime.now(UTC).isoformat())
    with transaction(db) as connection:
        connection.execute("INSERT OR IGNORE INTO participants (code, created_at) VALUES (?, ?)", row)
    return code


def codes(db: sqlite3.Connection) -> list[str]:
    """Return the codes of all participants of live sessions, sorted."""
    return [code for (code,) in db.execute("SELECT code FROM participants ORDER BY code")]


def last_used(db: sqlite3.Connection) -> str | None:
    """Return the (first) participant of the live session that was begun or resumed last; None without a session."""
    row = db.execute(
        "SELECT participant FROM runs JOIN sessions ON sessions.id = runs.session"
        " JOIN seats ON seats.session = runs.session AND seat='A' WHERE mode='live' ORDER BY runs.rowid DESC LIMIT 1"
    ).fetchone()
    return row[0] if row else None

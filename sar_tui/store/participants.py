"""Participants: pseudonymous codes, and the settings a therapist keeps for each."""

import re
from datetime import UTC, datetime
from typing import Any

import msgspec
import sqlite_utils

from sar_tui.store.database import StoreError, transaction

_CODE = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,31}")


def check_code(code: str) -> str:
    """A code as it is kept. Raises StoreError for what cannot be one."""
    code = code.strip().upper()
    if not _CODE.fullmatch(code):
        raise StoreError(
            "A participant code has 1 to 32 letters, digits, - or _, and begins with a letter or digit, such as P01. "
            "Never use a name.",
            bad_input=True,
        )
    return code


def add(db: sqlite_utils.Database, code: str) -> str:
    """Make sure a participant is known; returns the code as it is kept.

    Raises:
        StoreError: it cannot be a code, or the disk refuses.
    """
    code = check_code(code)
    row = (code, datetime.now(UTC).isoformat())
    with transaction(db) as connection:
        connection.execute("INSERT OR IGNORE INTO participants (code, created_at) VALUES (?, ?)", row)
    return code


def codes(db: sqlite_utils.Database) -> list[str]:
    """Everyone who took part in or is about to take part in a live session, in order."""
    return [code for (code,) in db.execute("SELECT code FROM participants ORDER BY code")]


class Settings(msgspec.Struct, frozen=True):
    """What a therapist set for a participant's next session of a task: only what differs from the defaults."""

    parameters: dict[str, Any] = {}
    theme: str = "calm"


def settings(db: sqlite_utils.Database, participant: str, task: str) -> Settings:
    """A participant's settings for a task; the defaults where none were saved."""
    row = db.execute(
        "SELECT parameters, theme FROM settings WHERE participant=? AND task=?", (participant, task)
    ).fetchone()
    return Settings(msgspec.json.decode(row[0]), row[1]) if row else Settings()


def save_settings(db: sqlite_utils.Database, participant: str, task: str, kept: Settings) -> None:
    """Keep a participant's settings for a task."""
    row = (participant, task, msgspec.json.encode(kept.parameters).decode(), kept.theme, datetime.now(UTC).isoformat())
    with transaction(db) as connection:
        connection.execute("INSERT OR REPLACE INTO settings VALUES (?,?,?,?,?)", row)

"""Interrupted sessions of this site that nobody goes on with. Nothing of them is deleted."""

import sqlite3
from pathlib import Path

from sar_tui.store import locks
from sar_tui.store.database import transaction


def dismiss(db: sqlite3.Connection, folder: Path, session: str) -> None:
    """Mark an interrupted session as not to be resumed; other sessions stay as they are.

    Raises:
        StoreError: a program has the session open, or the disk cannot write.
    """
    held = locks.hold(folder, "session", session)
    try:
        with transaction(db) as connection:
            connection.execute(
                "UPDATE sessions SET status='dismissed'"
                " WHERE id=? AND site='' AND status IN ('running', 'interrupted')",
                (session,),
            )
    finally:
        held.release()


def take_back(db: sqlite3.Connection, session: str) -> None:
    """Let a dismissed session be resumed again.

    Raises:
        StoreError: the disk cannot write.
    """
    with transaction(db) as connection:
        connection.execute(
            "UPDATE sessions SET status='interrupted' WHERE id=? AND site='' AND status='dismissed'", (session,)
        )

"""Changes of a session's record after the session. Each is a message in its log, stored with the change of its rows."""

import sqlite3
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path

import msgspec

from sar_tui.framework.messages import RecordChange, RecordChanged
from sar_tui.framework.topics import RECORD_CHANGED, SESSION_ENDED
from sar_tui.store import locks, log_hashes, messages
from sar_tui.store.database import transaction

_FROM: dict[RecordChange, tuple[str, ...]] = {
    "dismissed": ("running", "interrupted"),
    "discarded": ("running", "interrupted", "dismissed", "completed", "aborted"),
    "restored": ("dismissed", "discarded"),
}
"""The statuses of a session in which a change of its status is possible."""
BY_MISTAKE = "started by mistake"
"""Reason for which a session is discarded."""


def change_status(
    db: sqlite3.Connection, folder: Path, session: str, change: RecordChange, *, actor: str, reason: str = ""
) -> bool:
    """Dismiss, discard or restore a session of this site. Nothing of it is deleted.

    Returns:
        False if the session cannot be changed in this way, such as one that has ended and cannot be dismissed; nothing
        has changed then.

    Raises:
        StoreError: a program has the session open, or the disk cannot write.
    """
    held = locks.hold(folder, "session", session)
    try:
        with transaction(db) as connection:
            possible = ", ".join(f"'{status}'" for status in _FROM[change])
            own = f"SELECT 1 FROM sessions WHERE id=? AND site='' AND status IN ({possible})"
            if not connection.execute(own, (session,)).fetchone():
                return False
            log(connection, session, RecordChanged(change=change, actor=actor, at=_utc(), reason=reason))
            status = status_after(ends_and_changes(connection, session))
            connection.execute("UPDATE sessions SET status=? WHERE id=?", (status, session))
    finally:
        held.release()
    return True


def why_discarded(db: sqlite3.Connection, session: str) -> RecordChanged | None:
    """Return by whom and why a session was discarded; None if it is not."""
    found: RecordChanged | None = None
    texts = db.execute(
        "SELECT message FROM events WHERE session=? AND topic=? ORDER BY seq", (session, RECORD_CHANGED.name)
    )
    for (text,) in texts:
        said = msgspec.json.decode(text, type=RecordChanged)
        if said.change in ("discarded", "restored"):
            found = said if said.change == "discarded" else None
    return found


def log(connection: sqlite3.Connection, session: str, message: RecordChanged) -> None:
    """Append a message to a session's log, with the next number, as of its last run.

    Call it in the transaction that changes rows of the session, and hold the session's lock: a program that has it open
    numbers its own messages.
    """
    numbers = messages.add_numbers(connection, session)
    seq, run, at = messages.last(connection, session)
    connection.execute(
        "INSERT INTO messages (session_number, seq, run, at_ns, topic, message) VALUES (?,?,?,?,?,?)",
        (
            numbers.session,
            seq + 1,
            run,
            at,
            numbers.topics[RECORD_CHANGED.name],
            messages.encoder(RECORD_CHANGED)(message),
        ),
    )
    log_hashes.extend(connection, session)


def status_after(ends_and_changes: Iterable[str]) -> str:
    """Return the status of a session that nobody runs from its ends (see `SessionEnded`) and later changes."""
    ended, status = "interrupted", ""
    for each in ends_and_changes:
        match each:
            case "completed" | "aborted" | "refused":
                ended = each
            case "dismissed" | "discarded":
                status = each
            case "restored":
                status = ""
    return status or ended


def ends_and_changes(db: sqlite3.Connection, session: str) -> list[str]:
    """Return the ends of a session and what was done to it later, in order, as `status_after` takes them."""
    found = db.execute(
        "SELECT coalesce(json_extract(message, '$.change'), json_extract(message, '$.status')) FROM events"
        " WHERE session=? AND topic IN (?, ?) ORDER BY seq",
        (session, RECORD_CHANGED.name, SESSION_ENDED.name),
    )
    return [text for (text,) in found]


def _utc() -> str:
    return datetime.now(UTC).isoformat()

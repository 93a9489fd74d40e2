"""Changes of a session's record after the session. Each is a message in its log, stored with the
change of its rows.
"""

import contextlib
import sqlite3
from collections.abc import Iterable, Iterator
from datetime import datetime
from pathlib import Path

import msgspec

from sar_tui.loop.topics import RECORD_CHANGED, SESSION_ENDED
from sar_tui.model.messages import (
    Message,
    RecordChange,
    RecordChanged,
    SessionEnded,
)
from sar_tui.model.session_mode import is_personal
from sar_tui.store import locks, log_hashes, messages
from sar_tui.store.database import RESCUE, StoreError, transaction
from sar_tui.store.tables import MESSAGES
from sar_tui.store.training_days import utc

_FROM: dict[RecordChange, tuple[str, ...]] = {
    "dismissed": ("running", "interrupted"),
    "discarded": ("running", "interrupted", "dismissed", "completed", "aborted", "refused"),
    "restored": ("dismissed", "discarded"),
}
"""The statuses of a session in which a change of its status is possible."""
BY_MISTAKE = "started by mistake"
"""Reason for which a session is discarded."""


def change_status(
    db: sqlite3.Connection,
    folder: Path,
    session: str,
    change: RecordChange,
    *,
    actor: str,
    reason: str = "",
    now: datetime | None = None,
) -> bool:
    """Dismiss, discard or restore a session of this site. Nothing of it is deleted.

    ``now``: when that is; None for the present.

    Returns:
        False if the session cannot be changed in this way, such as one that has ended and cannot be
        dismissed; nothing
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
            log(
                connection,
                session,
                RecordChanged(change=change, actor=actor, at=utc(now), reason=reason),
            )
            status = status_after(ends_and_changes(connection, session))
            connection.execute("UPDATE sessions SET status=? WHERE id=?", (status, session))
    finally:
        held.release()
    return True


def move(
    db: sqlite3.Connection,
    folder: Path,
    session: str,
    seat: str,
    to: str,
    *,
    actor: str,
    reason: str,
    now: datetime | None = None,
) -> str:
    """Move a live session of this site to another participant, who is known, with the records that
    belong to it. The earlier code stays in its log.

    Args:
        db, folder, session: the session, which no program has open.
        seat: A, or B in a session for two.
        to: the code of the participant.
        actor, reason: who moves it, and why.

    Returns:
        The code of the participant until then.

    Raises:
        StoreError: it is of another site or not of a person, nobody sits there, ``to`` sits in it
            already, a program has it open, a rescue file of it waits, or the disk cannot write.
    """
    held = locks.hold(folder, "session", session)
    try:
        if files := sorted(folder.glob(f"{RESCUE}{session}*.db")):
            raise StoreError(
                f"The last messages of session {session} are in {files[0]}. Run `sar-tui rescue` "
                "first.",
                bad_input=True,
            )
        with transaction(db) as connection:
            before = check_movable(connection, session, seat, to)
            connection.execute(
                "UPDATE seats SET participant=? WHERE session=? AND seat=?", (to, session, seat)
            )
            connection.execute(
                "UPDATE records SET participant=? WHERE session=? AND participant=?",
                (to, session, before),
            )
            said = RecordChanged(
                change="moved",
                seat=seat,
                actor=actor,
                at=utc(now),
                reason=reason,
                details={"before": before, "after": to},
            )
            log(connection, session, said)
    finally:
        held.release()
    return before


def check_movable(db: sqlite3.Connection, session: str, seat: str, to: str) -> str:
    """Return the code of the participant at a seat of a session. Raises StoreError if it cannot be
    moved to another one.
    """
    row = db.execute("SELECT site, mode FROM sessions WHERE id=?", (session,)).fetchone()
    if row is None or row[0]:
        raise StoreError(
            f"The session {session} is of {row[0]}: it can be moved only there."
            if row
            else f"There is no session {session}.",
            bad_input=True,
        )
    if not is_personal(row[1]):
        raise StoreError(f"The session {session} is {row[1]}: nobody sat there.", bad_input=True)
    seats = log_hashes.seats(db, session)
    if seat not in seats:
        raise StoreError(
            f"The session {session} has no seat {seat}: it was for one person.", bad_input=True
        )
    if to in seats.values():
        raise StoreError(f"{to} is in the session {session} already.", bad_input=True)
    replaced = "SELECT 1 FROM people_events WHERE event='erased' AND replaced_by=?"
    if db.execute(replaced, (seats[seat],)).fetchone():
        raise StoreError(
            f"The participant at seat {seat} of session {session} was erased.", bad_input=True
        )
    return seats[seat]


def code_at_first(db: sqlite3.Connection, session: str, seat: str, code: str) -> str:
    """Return the code that a participant of a session had when it was recorded, as far as its log
    tells.
    """
    for change in changes(db, session):
        if change.change == "moved" and change.seat == seat and change.details:
            return str(change.details["before"])
    return code


def erased_hashes(db: sqlite3.Connection, session: str) -> dict[tuple[str, bytes], bytes]:
    """Return the hashes of messages, and of rows beside them, as they were before they or texts of
    them were erased, by their names and the hashes of what remains of them.
    """
    found: dict[tuple[str, bytes], bytes] = {}
    for change in changes(db, session):
        if change.change in ("redacted", "erased"):
            for name, hashes in change.details.items():
                with contextlib.suppress(ValueError):
                    before, after = map(bytes.fromhex, str(hashes).split())
                    found[name, after] = before
    return found


def changes(db: sqlite3.Connection, session: str) -> list[RecordChanged]:
    """Return what was done to a session later, in order."""
    return [
        one for one in _readable(db, session, RECORD_CHANGED.name) if isinstance(one, RecordChanged)
    ]


def check_not_erased(db: sqlite3.Connection, session: str) -> None:
    """Raise StoreError if a participant's part of a session was erased: it cannot run again."""
    if any(change.change == "erased" for change in changes(db, session)):
        raise StoreError(
            f"The part of a participant in session {session} was erased: what is left cannot be "
            "run again.",
            bad_input=True,
        )


def _readable(db: sqlite3.Connection, session: str, *topics: str) -> Iterator[Message]:
    """Yield a session's messages of some topics, except those that are damaged, which `integrity`
    finds.
    """
    for row in messages.stored_rows(db, session, topics=topics):
        with contextlib.suppress(KeyError, TypeError, msgspec.MsgspecError):
            yield messages.decoded(row)


def why_discarded(db: sqlite3.Connection, session: str) -> RecordChanged | None:
    """Return by whom and why a session was discarded; None if it is not."""
    found: RecordChanged | None = None
    for said in changes(db, session):
        if said.change in ("discarded", "restored"):
            found = said if said.change == "discarded" else None
    return found


def log(connection: sqlite3.Connection, session: str, message: RecordChanged) -> None:
    """Append a message to a session's log, with the next number, as of its last run.

    Call it in the transaction that changes rows of the session, and hold the session's lock: a
    program that has it open numbers its own messages.
    """
    numbers = messages.add_numbers(connection, session)
    seq, run, at = messages.last(connection, session)
    connection.execute(
        MESSAGES.insert(),
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
    """Return the status of a session that nobody runs from its ends (see `SessionEnded`) and later
    changes.
    """
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
    """Return the ends of a session and what was done to it later, in order, as `status_after` takes
    them.
    """
    found: list[str] = []
    for one in _readable(db, session, RECORD_CHANGED.name, SESSION_ENDED.name):
        if isinstance(one, RecordChanged):
            found.append(one.change)
        elif isinstance(one, SessionEnded):
            found.append(one.status)
    return found

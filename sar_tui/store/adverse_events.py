"""Adverse events, append-only: each has its onset, severity, action and outcome."""

import re
import secrets
import sqlite3
from datetime import UTC, datetime, timedelta
from typing import Any, Literal, get_args

import msgspec

from sar_tui.store.counted import LIVE
from sar_tui.store.database import StoreError, transaction
from sar_tui.store.participants import add, admit, check_own
from sar_tui.store.texts import check_text

Severity = Literal["mild", "moderate", "severe"]
SEVERITIES: tuple[str, ...] = get_args(Severity)
LONGEST_REMARK = 2000
"""Characters of what is said of an event."""
_DATE = re.compile(r"\d{4}-\d{2}-\d{2}([ T]\d{2}:\d{2})?")


class AdverseEvent(msgspec.Struct, frozen=True, kw_only=True):
    """An adverse event as it is known now.

    Attributes:
        event: its id, the same in all its versions.
        version: 1 when it was reported; each amendment adds one, and the earlier ones are kept.
        onset: local date, or date and time, at which it began.
        session: the session in which it began; None if it was none.
        severity: mild, moderate or severe.
        action: what was done. ``outcome``: how it ended. Both may be empty at first.
        recorded_at: UTC. ``recorded_by``: the login name of the user who recorded this version.
    """

    event: str
    version: int
    participant: str
    session: str | None = None
    onset: str
    what: str
    severity: str
    action: str = ""
    outcome: str = ""
    recorded_at: str = ""
    recorded_by: str = ""


_FIELDS = AdverseEvent.__struct_fields__


def check_onset(text: str) -> str:
    """Return an onset as it is stored: "2026-03-01" or "2026-03-01 14:30". Raises StoreError."""
    onset = text.strip()
    try:
        if not _DATE.fullmatch(onset):
            raise ValueError
        began = datetime.fromisoformat(onset)
    except ValueError:
        raise StoreError(
            f"The onset must be a date, such as 2026-03-01 or 2026-03-01T14:30, not {text!r}.",
            bad_input=True,
        ) from None
    if began > datetime.now():
        raise StoreError(f"The onset {onset} is in the future.", bad_input=True)
    return onset.replace("T", " ")


def session_at(db: sqlite3.Connection, participant: str, onset: str) -> str | None:
    """Return the live session of a participant that was under way at an onset; None without a time,
    or a session.

    Raises:
        StoreError: the onset is not valid.
    """
    checked = check_onset(onset)
    if len(checked) == len("2026-03-01"):
        return None
    at = datetime.fromisoformat(checked).astimezone(UTC)
    row = db.execute(
        "SELECT sessions.id FROM seats CROSS JOIN sessions ON sessions.id=seats.session"
        f" WHERE participant=? AND {LIVE} AND started_at < ? AND ended_at >= ?"
        " ORDER BY seats.rowid DESC LIMIT 1",
        (participant, (at + timedelta(minutes=1)).isoformat(), at.isoformat()),
    ).fetchone()
    return row[0] if row else None


def report(
    db: sqlite3.Connection,
    participant: str,
    *,
    onset: str,
    what: str,
    severity: str,
    action: str = "",
    outcome: str = "",
    session: str | None = None,
    author: str = "",
    is_new: bool = False,
) -> AdverseEvent:
    """Store a new adverse event, and return it. ``is_new``: as in `participants.admit`.

    Raises:
        StoreError: the participant is not known, a value is not valid, or the disk cannot write.
    """
    (code,) = admit(db, [participant], is_new=is_new)
    event = AdverseEvent(
        event=secrets.token_hex(3),
        version=1,
        participant=code,
        session=session,
        onset=check_onset(onset),
        what=_text("what", what, needed=True),
        severity=_severity(severity),
        action=_text("action", action),
        outcome=_text("outcome", outcome),
        recorded_at=datetime.now(UTC).isoformat(),
        recorded_by=author,
    )
    add(db, code)
    return _insert(db, event)


def amend(
    db: sqlite3.Connection, event: str, author: str = "", **changes: str | None
) -> AdverseEvent:
    """Store a new version of an adverse event, and return it; the earlier versions stay.

    Args:
        db: the database.
        event: its id.
        author: who records it.
        changes: new values of ``onset``, ``what``, ``severity``, ``action`` or ``outcome``; None
            keeps one.

    Raises:
        StoreError: there is no such event, nothing would change, a value is not valid, or the disk
            cannot write.
    """
    found = versions(db, event)
    _, sign, site = event.partition("@")
    if found and sign:
        raise StoreError(
            f"The adverse event {event} is of {site}: it can be amended only there.", bad_input=True
        )
    if not found:
        raise StoreError(
            f"There is no adverse event {event}. `sar-tui adverse list` lists them.", bad_input=True
        )
    given = {name: value for name, value in changes.items() if value is not None}
    if "onset" in given:
        given["onset"] = check_onset(given["onset"])
    if "severity" in given:
        given["severity"] = _severity(given["severity"])
    for name in ("what", "action", "outcome"):
        if name in given:
            given[name] = _text(name, given[name], needed=name == "what")
    last = found[-1]
    if all(getattr(last, name) == value for name, value in given.items()):
        raise StoreError(
            "Nothing would change. Give a new onset, what, severity, action or outcome.",
            bad_input=True,
        )
    now = datetime.now(UTC).isoformat()
    changed = msgspec.structs.replace(
        last, **given, version=last.version + 1, recorded_at=now, recorded_by=author
    )
    return _insert(db, changed)


def listing(
    db: sqlite3.Connection, participant: str | None = None, session: str | None = None
) -> list[AdverseEvent]:
    """Return the adverse events as they are known now, by onset; only those of a participant or
    session if given.
    """
    newest = {one.event: one for one in _select(db)}
    wanted = (
        one
        for one in newest.values()
        if participant in (None, one.participant) and (session is None or one.session == session)
    )
    return sorted(wanted, key=lambda one: one.onset)


def versions(db: sqlite3.Connection, event: str) -> list[AdverseEvent]:
    """Return all versions of an adverse event, the first one first."""
    return _select(db, "WHERE event=?", event)


def _select(db: sqlite3.Connection, condition: str = "", *values: str) -> list[AdverseEvent]:
    rows = db.execute(
        f"SELECT {', '.join(_FIELDS)} FROM adverse_events {condition} ORDER BY version", values
    )
    return [AdverseEvent(**dict[str, Any](zip(_FIELDS, row, strict=True))) for row in rows]


def _insert(db: sqlite3.Connection, event: AdverseEvent) -> AdverseEvent:
    check_own(event.participant)
    slots = ",".join("?" for _ in _FIELDS)
    with transaction(db) as connection:
        connection.execute(
            f"INSERT INTO adverse_events ({', '.join(_FIELDS)}) VALUES ({slots})",
            msgspec.structs.astuple(event),
        )
    return event


def _severity(text: str) -> str:
    if text.strip().lower() not in SEVERITIES:
        raise StoreError(
            f"The severity must be {', '.join(SEVERITIES[:-1])} or {SEVERITIES[-1]}.",
            bad_input=True,
        )
    return text.strip().lower()


def _text(name: str, text: str, *, needed: bool = False) -> str:
    """Return a text without blanks at its ends. Raises StoreError if it is missing, or `check_text`
    refuses it.
    """
    cleaned = check_text(f"The text for {name}", text, LONGEST_REMARK)
    if needed and not cleaned:
        raise StoreError("Say what happened, in a few words.", bad_input=True)
    return cleaned

"""Participants: pseudonymous codes."""

import re
import sqlite3
from datetime import UTC, datetime
from difflib import get_close_matches
from pathlib import Path

import msgspec

from sar_tui.store.counted import COUNTS, LIVE
from sar_tui.store.database import StoreError, transaction
from sar_tui.store.locks import is_held

_CODE = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,31}(@[A-Za-z0-9][A-Za-z0-9-]{0,15})?")


def check_code(code: str) -> str:
    """Return a code as it is stored, in capital letters. Raise StoreError if it is not valid.

    A participant of another site has its code behind an @: P01@BERN.
    """
    code = code.strip()
    if not _CODE.fullmatch(code):  # before the capitals: those of ß and ı are letters of other codes
        raise StoreError(
            "A participant code has 1 to 32 letters, digits, - or _, and begins with a letter or digit, such as P01. "
            "Never use a name.",
            bad_input=True,
        )
    return code.upper()


def check_own(code: str) -> str:
    """Return a code as it is stored. Raise StoreError if it is not valid, or of a participant of another site."""
    code = check_code(code)
    _, sign, site = code.partition("@")
    if sign:
        raise StoreError(
            f"{code} is a participant of {site}: what {site} recorded can be looked at, and is changed only there.",
            bad_input=True,
        )
    return code


def add(db: sqlite3.Connection, code: str) -> str:
    """Add a participant unless they are known, and return the code as it is stored.

    Raises:
        StoreError: the code is not valid, or of another site, or the disk cannot write.
    """
    code = check_own(code)
    row = (code, datetime.now(UTC).isoformat())
    with transaction(db) as connection:
        connection.execute("INSERT OR IGNORE INTO participants (code, created_at) VALUES (?, ?)", row)
    return code


def codes(db: sqlite3.Connection) -> list[str]:
    """Return the codes of this site's participants of live sessions, sorted."""
    return [code for (code,) in db.execute("SELECT code FROM participants WHERE site='' ORDER BY code")]


def check_known(db: sqlite3.Connection, code: str) -> str:
    """Return a code as it is stored, if anything is stored of this participant, such as a simulated session.

    Raises:
        StoreError: the code is not valid, or nobody has it. The message names codes that are much like it.
    """
    code = check_code(code)
    if any(db.execute(f"SELECT 1 FROM {table} WHERE {column}=? LIMIT 1", (code,)).fetchone() for table, column in _OF):
        return code
    known = sorted({each for table, column in _OF for (each,) in db.execute(f"SELECT DISTINCT {column} FROM {table}")})
    like = [each for each in known if _plain(each) == _plain(code)] or get_close_matches(code, known)
    meant = f" Is it {' or '.join(like)}?" if like else ""
    raise StoreError(f"There is no participant {code}.{meant}", bad_input=True)


_OF = (
    ("participants", "code"),
    ("seats", "participant"),
    ("instrument_scores", "participant"),
    ("wellbeing", "participant"),
)
"""Tables and their columns that hold the codes of participants."""


def _plain(code: str) -> str:
    """Return a code without what is easily left out: "P-01", "p1" and "P01" are alike."""
    return re.sub(r"(?<!\d)0+(?=\d)|[-_]", "", code.upper())


class Known(msgspec.Struct, frozen=True):
    """A participant with their newest session.

    Args:
        code: the code.
        session: id of the newest session; None without one.
        is_interrupted: True if one of the newest live sessions was interrupted, and was not dismissed.
    """

    code: str
    session: str | None
    is_interrupted: bool


_LOOKED_AT = 5
"""Newest sessions of a participant among which an interrupted one still waits."""
_NEWEST_FIRST = f"""SELECT code, newest.id,
    (SELECT group_concat(sessions.id || ' ' || status) FROM
        (SELECT session FROM seats WHERE participant=code ORDER BY seats.rowid DESC LIMIT {_LOOKED_AT}) AS own
        CROSS JOIN sessions ON sessions.id=own.session
        WHERE status IN ('running', 'interrupted') AND {LIVE} AND sessions.site='')
FROM participants LEFT JOIN sessions AS newest ON newest.id=
    (SELECT session FROM seats WHERE participant=code ORDER BY seats.rowid DESC LIMIT 1)
WHERE participants.site=''
ORDER BY max(coalesce(newest.started_at, ''), created_at) DESC, code"""
"""Each participant's seats are looked up from the newest on, so that only some of their sessions are read."""


def newest_first(db: sqlite3.Connection, folder: Path) -> list[Known]:
    """Return this site's participants of live sessions; first who began a session, or was added, last."""

    def waits(unfinished: str | None) -> bool:
        found = [each.split() for each in unfinished.split(",")] if unfinished else []
        return any(status == "interrupted" or not is_held(folder, "session", session) for session, status in found)

    return [Known(code, session, waits(unfinished)) for code, session, unfinished in db.execute(_NEWEST_FIRST)]


def last_task(db: sqlite3.Connection, participant: str) -> str | None:
    """Return the task of a participant's newest live session; without one, of their newest programme; or None."""
    row = (
        db.execute(
            "SELECT task FROM seats CROSS JOIN sessions ON sessions.id=seats.session"
            f" WHERE participant=? AND {COUNTS} ORDER BY seats.rowid DESC LIMIT 1",
            (participant,),
        ).fetchone()
        or db.execute(
            "SELECT task FROM programmes WHERE participant=? ORDER BY created_at DESC LIMIT 1", (participant,)
        ).fetchone()
    )
    return row[0] if row else None


def last_used(db: sqlite3.Connection) -> str | None:
    """Return the (first) participant of this site's live session that was begun or resumed last; None without one."""
    row = db.execute(
        "SELECT participant FROM runs JOIN sessions ON sessions.id = runs.session"
        f" JOIN seats ON seats.session = runs.session AND seat='A' WHERE {LIVE} AND site=''"
        " ORDER BY runs.rowid DESC LIMIT 1"
    ).fetchone()
    return row[0] if row else None

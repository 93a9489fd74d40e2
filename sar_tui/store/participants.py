"""Participants: pseudonymous codes."""

import re
import sqlite3
from collections.abc import Collection, Sequence
from datetime import datetime
from difflib import get_close_matches

from sar_tui.model.language import Sentence
from sar_tui.store.counted import COUNTS, LIVE
from sar_tui.store.database import StoreError, transaction
from sar_tui.store.people_events import check_may_record
from sar_tui.store.training_days import utc

_CODE = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,31}(@[A-Za-z0-9][A-Za-z0-9-]{0,15})?")


def check_code(code: str) -> str:
    """Return a code as it is stored, in capital letters. Raise StoreError if it is not valid.

    A participant of another site has its code behind an @: P01@BERN.
    """
    code = code.strip()
    # before the capitals: those of ß and ı are letters of other codes
    if not _CODE.fullmatch(code):
        raise StoreError(
            Sentence(
                "A participant code has 1 to 32 letters, digits, - or _, and begins with a letter "
                "or digit, such as P01. Never use a name."
            ),
            bad_input=True,
        )
    return code.upper()


def check_own(code: str) -> str:
    """Return a code as it is stored. Raise StoreError if it is not valid, or of a participant of
    another site.
    """
    code = check_code(code)
    _, sign, site = code.partition("@")
    if sign:
        raise StoreError(
            Sentence(
                "{code} is a participant of {site}: what {site} recorded can be looked at, and is "
                "changed only there.",
                code=code,
                site=site,
            ),
            bad_input=True,
        )
    return code


def add(db: sqlite3.Connection, code: str, now: datetime | None = None) -> str:
    """Add a participant unless they are known, and return the code as it is stored.

    ``now``: when that is; None for the present.

    Raises:
        StoreError: the code is not valid, or of another site, nothing may be recorded of them any
            more, or the disk cannot write.
    """
    with transaction(db) as connection:
        return store(connection, code, now)


def store(connection: sqlite3.Connection, code: str, now: datetime | None = None) -> str:
    """Add a participant as `add`, in a transaction of the caller."""
    code = check_own(code)
    check_may_record(connection, [code])
    connection.execute(
        "INSERT OR IGNORE INTO participants (code, created_at) VALUES (?, ?)", (code, utc(now))
    )
    return code


def codes(db: sqlite3.Connection) -> list[str]:
    """Return the codes of this site's participants of live sessions, sorted."""
    return [
        code for (code,) in db.execute("SELECT code FROM participants WHERE site='' ORDER BY code")
    ]


def check_known(db: sqlite3.Connection, code: str) -> str:
    """Return a code as it is stored, if anything is stored of this participant, such as a simulated
    session.

    Raises:
        StoreError: the code is not valid, or nobody has it. The message names codes that are much
            like it.
    """
    code = check_code(code)
    known = _codes_in(db, (*_RECORDS, "seats"))
    if code not in known:
        raise UnknownParticipant(code, known)
    return code


def admit(db: sqlite3.Connection, codes: Sequence[str], *, is_new: bool = False) -> list[str]:
    """Return codes as they are stored, if something may be recorded of these participants now.

    The one rule for all that records something of people: a code that nobody has here is probably a
    typing error, and would divide a person's record; a code that is given twice would mix the
    records of two people. Simulated sessions make nobody known.

    Args:
        codes: of the participants of a session, or of one person.
        is_new: True if the user says that those who are not known are new.

    Raises:
        UnknownParticipant: somebody is not known, and not said to be new.
        StoreError: a code is not valid, or of another site; somebody has withdrawn, or was erased;
            or ``is_new``, and all are known.
    """
    codes = [check_own(code) for code in codes]
    check_may_record(db, codes)
    known = _codes_in(db, _RECORDS)
    unknown = [code for code in codes if code not in known]
    if unknown and not is_new:
        raise UnknownParticipant(unknown[0], known)
    if is_new and not unknown:
        raise StoreError(
            f"{' and '.join(codes)} is known here already: leave out --new, or give a new "
            "participant another code.",
            bad_input=True,
        )
    return codes


class UnknownParticipant(StoreError):
    """Nobody has a code. The message names those that are much like it.

    Args:
        code: the code.
        known: those that somebody has.

    Attributes:
        like: the known codes that are much like it.
    """

    def __init__(self, code: str, known: Collection[str]) -> None:
        self.code = code
        alike = sorted(each for each in known if _plain(each) == _plain(code))
        self.like = " or ".join(alike or get_close_matches(code, sorted(known), 1))
        text = (
            "There is no participant {code}. Is it {like}?"
            if self.like
            else "There is no participant {code}."
        )
        super().__init__(Sentence(text, code=code, like=self.like), bad_input=True)

    @property
    def advice(self) -> str:
        """Say in one sentence what to do where somebody is to be recorded, and nobody can be
        asked.
        """
        meant = f"give {self.like} if that is meant, or " if self.like else ""
        return f"There is no participant {self.code}: {meant}add --new for a new participant."


_RECORDS = ("participants", "programmes", "records")
"""Tables that hold something of people."""


def _codes_in(db: sqlite3.Connection, tables: Sequence[str]) -> set[str]:
    parts = (
        f"SELECT {'code' if table == 'participants' else 'participant'} FROM {table}"
        for table in tables
    )
    return {code for (code,) in db.execute(" UNION ".join(parts))}


_MISTAKEN = str.maketrans("OIL", "011")
"""Letters that are typed for digits."""


def _plain(code: str) -> str:
    """Return a code without what is easily left out or mistaken: "P-01", "p1", "P0l" and "P01" are
    alike.
    """
    return re.sub(r"(?<!\d)0+(?=\d)|[-_]", "", code.upper().translate(_MISTAKEN))


def last_task(db: sqlite3.Connection, participant: str) -> str | None:
    """Return the task of a participant's newest live session; without one, of their newest
    programme; or None.
    """
    row = (
        db.execute(
            "SELECT task FROM seats CROSS JOIN sessions ON sessions.id=seats.session"
            f" WHERE participant=? AND {COUNTS} ORDER BY seats.rowid DESC LIMIT 1",
            (participant,),
        ).fetchone()
        or db.execute(
            "SELECT task FROM programmes WHERE participant=? ORDER BY created_at DESC LIMIT 1",
            (participant,),
        ).fetchone()
    )
    return row[0] if row else None


def last_used(db: sqlite3.Connection) -> str | None:
    """Return the (first) participant of this site's live session that was begun or resumed last;
    None without one.
    """
    row = db.execute(
        "SELECT participant FROM runs JOIN sessions ON sessions.id = runs.session"
        f" JOIN seats ON seats.session = runs.session AND seat='A' WHERE {LIVE} AND site=''"
        " ORDER BY runs.rowid DESC LIMIT 1"
    ).fetchone()
    return row[0] if row else None

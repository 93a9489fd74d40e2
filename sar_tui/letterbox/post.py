"""Messages, training days and requests of a clinic to a person at home, as records of theirs."""

import sqlite3
from datetime import datetime

from sar_tui.letterbox.contents import KINDS_OF_CLINIC
from sar_tui.letterbox.status import DAYS
from sar_tui.records.kind import LONGEST_TEXT
from sar_tui.store import records
from sar_tui.store.database import StoreError
from sar_tui.store.records import Record

MESSAGE, PLAN, REQUEST = KINDS_OF_CLINIC
LONGEST_MESSAGE = 300
"""Characters of a message: what a screen shows in large print."""


def write_message(
    db: sqlite3.Connection, participant: str, text: str, *, author: str, now: datetime | None = None
) -> Record:
    """Store a message. Raises StoreError: it is empty or too long, or nobody has the code."""
    assert LONGEST_MESSAGE <= LONGEST_TEXT
    if len(text.strip()) > LONGEST_MESSAGE:
        raise StoreError(
            f"A message has at most {LONGEST_MESSAGE} characters: it is shown in large print. This "
            f"one has {len(text.strip())}.",
            bad_input=True,
        )
    return _add(db, MESSAGE, participant, {"text": text.strip()}, author, now)


def plan_days(
    db: sqlite3.Connection,
    participant: str,
    days: list[str],
    *,
    author: str,
    now: datetime | None = None,
) -> Record:
    """Store the days of the week on which a person is to train. Raises StoreError."""
    known = {day.strip(",.").casefold()[:3] for day in days}
    wrong = sorted(day for day in known if day not in DAYS)
    if wrong or not known:
        raise StoreError(
            f"Days are {', '.join(day.capitalize() for day in DAYS)}"
            + (f", not {wrong[0][:20]!r}." if wrong else "."),
            bad_input=True,
        )
    in_order = " ".join(day for day in DAYS if day in known)
    return _add(db, PLAN, participant, {"days": in_order}, author, now)


def request_form(
    db: sqlite3.Connection, participant: str, form: str, *, author: str, now: datetime | None = None
) -> Record:
    """Ask a person to fill in a form at home. Raises StoreError: it cannot be filled in."""
    kind = records.kind_of(form)
    if kind.form is None:
        raise StoreError(f"{form} is no form. sar-tui record kinds lists them.", bad_input=True)
    if kind.why_unusable:
        raise StoreError(kind.why_unusable, bad_input=True)
    return _add(db, REQUEST, participant, {"form": kind.name}, author, now)


def _add(
    db: sqlite3.Connection,
    name: str,
    participant: str,
    values: dict[str, str],
    author: str,
    now: datetime | None,
) -> Record:
    return records.add(db, records.kind_of(name), participant, "", values, author=author, now=now)

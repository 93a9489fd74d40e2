"""Uses of people's rights, as a table has them: withdrawals, de-identifications and erasures.

Rows are added and never changed, so that a merge takes all of them whatever the order.
"""

import secrets
import sqlite3
from collections.abc import Iterable
from datetime import date, datetime
from typing import Literal

import msgspec

from sar_tui.model.language import Sentence
from sar_tui.store.database import StoreError, damaged, store, transaction
from sar_tui.store.tables import PEOPLE_EVENTS
from sar_tui.store.texts import check_text
from sar_tui.store.training_days import utc

What = Literal["withdrawn", "resumed", "de-identified", "erased"]
Data = Literal["", "keep", "exclude"]
"""Fate of the data of a person who has withdrawn; empty for other events."""
LONGEST_REASON = 500


class Details(msgspec.Struct, frozen=True, omit_defaults=True):
    """Details of an event, besides its columns.

    Attributes:
        data, on: of a withdrawal; the day of which it is, if that is not the one on which it was
            recorded.
        sessions: of a de-identification or an erasure, the seat of the person in each session, by
            its id. ``records``: the ids of their records.
    """

    data: Data = ""
    on: str = ""
    sessions: dict[str, str] = {}
    records: tuple[str, ...] = ()


class PersonEvent(msgspec.Struct, frozen=True, kw_only=True):
    """A row of ``people_events``."""

    id: str
    event: What
    participant: str
    at: str
    recorded_by: str = ""
    reason: str = ""
    details: Details = Details()
    replaced_by: str = ""
    site: str = ""

    @property
    def day(self) -> str:
        """The day of which it is, such as 2026-03-01."""
        return self.details.on or self.at[:10]


def check_day(text: str) -> str:
    """Return a day as it is stored. Raises StoreError: it is none, or in the future."""
    try:
        day = date.fromisoformat(text.strip())
    except ValueError:
        raise StoreError(
            f"A day is given as 2026-03-01, not {text[:40]!r}.", bad_input=True
        ) from None
    if day > date.today():
        raise StoreError(f"The day {day} is in the future.", bad_input=True)
    return day.isoformat()


def new_event(
    what: What,
    participant: str,
    *,
    author: str,
    reason: str,
    details: Details = Details(),  # noqa: B008 - it is frozen
    replaced_by: str = "",
    now: datetime | None = None,
) -> PersonEvent:
    """Return an event of this site that is not stored yet. Raises StoreError: the reason is not a
    text that can be stored.
    """
    return PersonEvent(
        id=secrets.token_hex(8),
        event=what,
        participant=participant,
        at=utc(now),
        recorded_by=author,
        reason=check_text("The reason", reason, LONGEST_REASON),
        details=details,
        replaced_by=replaced_by,
    )


def insert(connection: sqlite3.Connection, event: PersonEvent) -> None:
    """Store an event, in a transaction of the caller."""
    values = msgspec.structs.asdict(event)
    values["details"] = msgspec.to_builtins(event.details)
    store(connection, PEOPLE_EVENTS, **values)


def add(db: sqlite3.Connection, event: PersonEvent) -> None:
    """Store an event. Raises StoreError."""
    with transaction(db) as connection:
        insert(connection, event)


def events(db: sqlite3.Connection, participants: Iterable[str] | None = None) -> list[PersonEvent]:
    """Return the events of some participants, or of all, in the order of their time.

    Raises:
        StoreError: a row is damaged.
    """
    names = PEOPLE_EVENTS.names
    where, values = "", tuple[str, ...]()
    if participants is not None:
        where = " WHERE participant IN (SELECT value FROM json_each(?))"
        values = (msgspec.json.encode(list(participants)).decode(),)
    rows = db.execute(
        f"SELECT {', '.join(names)} FROM people_events{where} ORDER BY at, id", values
    )
    return [_event(dict(zip(names, row, strict=True))) for row in rows]


def _event(row: dict[str, object]) -> PersonEvent:
    try:
        details = msgspec.json.decode(str(row["details"]), type=Details)
        return msgspec.convert({**row, "details": details}, PersonEvent)
    except msgspec.MsgspecError as error:
        raise damaged() from error


# --- what follows from them


def withdrawal(db: sqlite3.Connection, participant: str) -> PersonEvent | None:
    """Return the withdrawal of a participant; None if there is none, or it was taken back."""
    return withdrawals(events(db, [participant])).get(participant)


def withdrawals(some: Iterable[PersonEvent]) -> dict[str, PersonEvent]:
    """Return the withdrawals among events in the order of their time, without those that were taken
    back, by code.
    """
    last = {event.participant: event for event in some if event.event in ("withdrawn", "resumed")}
    return {code: event for code, event in last.items() if event.event == "withdrawn"}


def erasure(db: sqlite3.Connection, participant: str) -> PersonEvent | None:
    """Return the erasure of a participant; None if there is none."""
    found = [event for event in events(db, [participant]) if event.event == "erased"]
    return found[0] if found else None


def excluded(db: sqlite3.Connection) -> dict[str, PersonEvent]:
    """Return the withdrawals of participants whose data is excluded, by code."""
    found = withdrawals(events(db))
    return {code: event for code, event in found.items() if event.details.data == "exclude"}


def check_may_record(db: sqlite3.Connection, codes: Iterable[str]) -> None:
    """Raise StoreError if nothing new may be recorded of one of some participants: they have
    withdrawn, or were erased.
    """
    found = events(db, codes)
    for event in found:
        if event.event == "erased":
            raise StoreError(
                Sentence(
                    "The data of {code} was erased on {date}: give a new participant another code.",
                    code=event.participant,
                    date=event.day,
                ),
                bad_input=True,
            )
    for code, event in withdrawals(found).items():
        raise StoreError(
            Sentence(
                "{code} has withdrawn on {date}: nothing more is recorded of them.",
                code=code,
                date=event.day,
            ),
            bad_input=True,
        )


def check_included(db: sqlite3.Connection, code: str) -> None:
    """Raise StoreError if the data of a participant is excluded from exports, reports and
    progress.
    """
    found = withdrawal(db, code)
    if found and found.details.data == "exclude":
        raise StoreError(excluded_words(found), bad_input=True)


def excluded_words(found: PersonEvent) -> Sentence:
    """Return the sentence on a participant whose data is excluded."""
    return Sentence(
        "{code} has withdrawn on {date}, and their data is excluded.",
        code=found.participant,
        date=found.day,
    )

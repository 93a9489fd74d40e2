"""Forms that are being filled in: a record that each answer adds a version to."""

import sqlite3
from datetime import UTC, date, datetime
from typing import NamedTuple

from sar_tui.records.kind import (
    COMPLETE,
    LANGUAGE,
    NOT_SAID,
    OPEN,
    STATUS,
    Field,
    Kind,
    RecordError,
    Value,
    missing_of,
    time_of,
    unusable_files,
)
from sar_tui.store import records
from sar_tui.store.database import StoreError
from sar_tui.store.records import Record


class Occasion(NamedTuple):
    """The person who fills in a form, and the session that it belongs to.

    Attributes:
        participant: code of the participant.
        session, seat, moment: as of a record.
    """

    participant: str
    session: str | None = None
    seat: str = "A"
    moment: str = ""


def form(name: str) -> Kind:
    """Return a form that can be filled in here. Raises StoreError."""
    kind = records.kind_of(name)
    if kind.form is None:
        raise StoreError(f"{kind.name} is no form. `sar-tui record add` enters it.", bad_input=True)
    if why := kind.why_unusable:
        raise StoreError(" ".join((*unusable_files(), why)), bad_input=True)
    return kind


def left_open(
    db: sqlite3.Connection, kind: Kind, of: Occasion, today: date | None = None
) -> Record | None:
    """Return the form that was begun on this day for the same occasion, and is not complete. None
    if its declaration has changed so that the answers are none of it.
    """
    last = newest(db, kind, of)
    if last is None or last.content.get(STATUS) != OPEN or not _is_of(kind, last):
        return None
    return last if _local_day(last) == (today or date.today()) else None


def _is_of(kind: Kind, record: Record) -> bool:
    """Return True if a record is as its form declares it today, with something left to answer."""
    try:
        return kind.read(record.content) == record.content
    except RecordError:
        return False


def newest(db: sqlite3.Connection, kind: Kind, of: Occasion) -> Record | None:
    """Return the form that was begun last for an occasion, complete or not; None if there is
    none.
    """
    found = records.listing(db, kinds=(kind.name,), participant=of.participant, session=of.session)
    here = (of.session, of.seat, of.moment)
    own = [each for each in found if (each.session, each.seat, each.moment) == here]
    return own[-1] if own else None


def is_complete(record: Record) -> bool:
    """Return True if all items of a form were answered, or declined."""
    return record.content.get(STATUS) == COMPLETE


def _local_day(record: Record) -> date:
    began = datetime.fromisoformat(record.at)
    return (began if began.tzinfo else began.replace(tzinfo=UTC)).astimezone().date()


class FormAnswers:
    """The answers of a form, each of which is stored at once.

    Args:
        db: the database.
        kind: the form.
        of: who fills it in, and where it belongs.
        language: of the participant; a form that was left open stays in that in which it was begun.
        today: the date of the people in front of the screen.

    Attributes:
        record: as it is stored; None before the first answer.
        language: in which the form is shown.
    """

    def __init__(
        self,
        db: sqlite3.Connection,
        kind: Kind,
        of: Occasion,
        language: str = "en",
        today: date | None = None,
    ) -> None:
        self._db, self._kind, self._of = db, kind, of
        self.record = left_open(db, kind, of, today)
        begun_in = self.record.content.get(LANGUAGE) if self.record else None
        self.language = kind.language_shown(str(begun_in or language))

    @property
    def given(self) -> dict[str, Value]:
        """The answers so far, by item."""
        content = self.record.content if self.record else {}
        return {item.name: content[item.name] for item in self._kind.items if item.name in content}

    def answer(self, item: Field, value: Value | None, ms: int) -> None:
        """Store an answer, None if somebody would rather not say, and the time that it took. The
        time of an item that is answered again is that of all its answers.

        Raises:
            StoreError: it is not valid, or the disk cannot write.
        """
        known = self.record.content if self.record else {}
        so_far = known.get(time_of(item), 0)
        given = {
            item.name: NOT_SAID if value is None else value,
            time_of(item): (so_far if isinstance(so_far, int) else 0) + max(0, ms),
            LANGUAGE: self.language,
        }
        if self.record:
            if given.items() - known.items():
                self.record = records.correct(self._db, self.record.id, given)
            return
        of = self._of
        self.record = records.add(
            self._db,
            self._kind,
            of.participant,
            "",
            {STATUS: OPEN, **given},
            session=of.session,
            seat=of.seat,
            moment=of.moment,
        )


def summary(record: Record, kind: Kind) -> str:
    """Return the scores of a form in words, or how far it is filled in."""
    done = sum(item.name in record.content for item in kind.items)
    if record.content.get(STATUS) == OPEN or not kind.scores:
        said = "left open: " * (record.content.get(STATUS) == OPEN)
        return f"{said}{done} of {len(kind.items)} items answered"
    found = []
    for score in kind.scores:
        value = record.content.get(score.name)
        missing = record.content.get(missing_of(score))
        said = f"{value:g}" if isinstance(value, int | float) else "no score"
        without = f", {missing} missing" if missing else ""
        found.append(f"{score.title} {said} ({kind.field(score.name).range}{without})")
    return "; ".join(found)

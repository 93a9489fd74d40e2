"""Records of people as tests need them: pain and tiredness as the app stores them, events, scores."""

import sqlite3
from typing import Any

from sar_tui.records.kind import NOT_SAID, find
from sar_tui.store import records
from sar_tui.store.records import Record
from sar_tui.store.wellbeing import PAIN, RATED, TIREDNESS


def told(
    database: sqlite3.Connection,
    code: str,
    moment: str,
    question: str,
    answer: str,
    *,
    session: str | None = None,
    seat: str = "A",
) -> Record:
    """Store what a participant said of ``pain``, ``tiredness``, or the ``place`` of the last pain or
    the ``advice`` on it.
    """
    if question in ("place", "advice"):
        (*_, last) = records.listing(database, kinds=(PAIN,), participant=code)
        return records.correct(database, last.id, {question: answer})
    content: dict[str, Any] = {"answer": RATED, "rating": answer}
    if answer == NOT_SAID:
        content = {"answer": NOT_SAID}
    kind = find(PAIN if question == "pain" else TIREDNESS)
    return records.add(database, kind, code, "", content, session=session, seat=seat, moment=moment)


def event(database: sqlite3.Connection, code: str, onset: str, **given: Any) -> Record:
    """Store an adverse event."""
    where = {name: given.pop(name) for name in ("session", "author", "is_new") if name in given}
    return records.add(database, find("adverse-event"), code, onset, given, **where)


def score(
    database: sqlite3.Connection, code: str, kind: str, day: str, value: float, note: str = ""
) -> Record:
    """Store a score of another test."""
    given = {"score": value, "note": note}
    return records.add(database, find(kind), code, day, given, author="ana")


def said(database: sqlite3.Connection) -> list[tuple[Any, ...]]:
    """Return what was said of pain and tiredness: moment, kind, and what else is known."""
    listed = records.listing(database, kinds=(PAIN, TIREDNESS))
    return [
        (
            each.moment,
            each.kind,
            *(v for name, v in each.content.items() if name != "answer" or v != RATED),
        )
        for each in listed
    ]

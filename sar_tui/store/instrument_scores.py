"""Scores of other instruments, entered by hand and append-only: for a day, what was entered last
counts.
"""

import math
import sqlite3
from datetime import UTC, date, datetime

from sar_tui.progress.instruments import INSTRUMENTS, Instrument, Score
from sar_tui.store import participants
from sar_tui.store.database import StoreError, transaction
from sar_tui.store.texts import check_text

LONGEST_NOTE = 2000


def add(
    db: sqlite3.Connection, participant: str, score: Score, *, author: str, is_new: bool = False
) -> Score:
    """Check and store a score, and return it as it is stored. ``is_new``: as in
    `participants.admit`.

    Raises:
        StoreError: the participant is not known, there is no such instrument, the score or the date
            cannot be, or the disk cannot write.
    """
    instrument = find(score.instrument)
    check_score(instrument, score.score)
    note = check_text("The note", score.note, LONGEST_NOTE)
    checked = Score(instrument.name, _date(score.date), score.score, note)
    (code,) = participants.admit(db, [participant], is_new=is_new)
    _insert(db, participants.add(db, code), checked, author)
    return checked


def remove(
    db: sqlite3.Connection, participant: str, instrument: str, on: str, *, author: str
) -> Score:
    """Remove a score that was entered by mistake, and return it; its rows stay, with one that says
    it is removed.

    Raises:
        StoreError: there is no such instrument, no score of it on that day, or the disk cannot
            write.
    """
    name, day = find(instrument).name, _date(on)
    for score in scores_of(db, participant):
        if (score.instrument, score.date) == (name, day):
            _insert(db, participant, score, author, removed=True)
            return score
    raise StoreError(f"{participant} has no score of {name} on {day}.", bad_input=True)


def find(name: str) -> Instrument:
    """Return an instrument by its name, in capital letters or not. Raises StoreError if there is
    none.
    """
    instrument = INSTRUMENTS.get(name.strip().upper())
    if instrument is None:
        raise StoreError(
            f"There is no instrument {name}. Choose one of: {', '.join(INSTRUMENTS)}.",
            bad_input=True,
        )
    return instrument


def check_score(instrument: Instrument, score: float) -> None:
    """Raise StoreError if an instrument has no such score."""
    if not math.isfinite(score) or not instrument.lowest <= score <= instrument.highest:
        raise StoreError(
            f"A score of {instrument.name} lies between {instrument.lowest:g} and "
            f"{instrument.highest:g}, "
            f"not at {score:g}.",
            bad_input=True,
        )


def _insert(
    db: sqlite3.Connection, participant: str, score: Score, author: str, *, removed: bool = False
) -> None:
    row = (
        participant,
        score.instrument,
        score.date,
        score.score,
        score.note,
        _now(),
        author,
        removed,
    )
    with transaction(db) as connection:
        connection.execute(
            "INSERT INTO instrument_scores (participant, instrument, date, score, note, "
            "recorded_at, recorded_by,"
            " removed) VALUES (?,?,?,?,?,?,?,?)",
            row,
        )


def scores_of(db: sqlite3.Connection, participant: str) -> list[Score]:
    """Return the scores of a participant, oldest first."""
    rows = db.execute(
        "SELECT instrument, date, score, note, removed FROM instrument_scores WHERE participant=?"
        " ORDER BY date, recorded_at",
        (participant,),
    )
    last = {
        (instrument, on): (score, note, removed) for instrument, on, score, note, removed in rows
    }
    return [
        Score(instrument, on, score, note)
        for (instrument, on), (score, note, removed) in last.items()
        if not removed
    ]


def _date(text: str) -> str:
    try:
        found = date.fromisoformat(text.strip())
    except ValueError:
        raise StoreError(
            f"The date must be one such as 2026-03-01, not {text!r}.", bad_input=True
        ) from None
    if found > date.today():
        raise StoreError(f"The date {found} is in the future.", bad_input=True)
    return found.isoformat()


def _now() -> str:
    return datetime.now(UTC).isoformat()

"""Scores of other instruments, entered by hand and append-only: for a day, the one entered last counts."""

import math
import sqlite3
from datetime import UTC, date, datetime

from sar_tui.progress.instruments import INSTRUMENTS, Score
from sar_tui.store.database import StoreError, transaction

_LONGEST_NOTE = 2000


def add(db: sqlite3.Connection, participant: str, score: Score, *, author: str) -> Score:
    """Check and store a score, and return it as it is stored.

    Raises:
        StoreError: there is no such instrument, the score or the date cannot be, or the disk cannot write.
    """
    instrument = INSTRUMENTS.get(score.instrument.strip().upper())
    if instrument is None:
        raise StoreError(
            f"There is no instrument {score.instrument}. Choose one of: {', '.join(INSTRUMENTS)}.", bad_input=True
        )
    if not math.isfinite(score.score) or not instrument.lowest <= score.score <= instrument.highest:
        raise StoreError(
            f"A score of {instrument.name} lies between {instrument.lowest:g} and {instrument.highest:g}, "
            f"not at {score.score:g}.",
            bad_input=True,
        )
    if len(score.note) > _LONGEST_NOTE:
        raise StoreError(f"A note has at most {_LONGEST_NOTE} characters.", bad_input=True)
    checked = Score(instrument.name, _date(score.date), score.score, score.note.strip())
    row = (participant, checked.instrument, checked.date, checked.score, checked.note)
    with transaction(db) as connection:
        connection.execute("INSERT INTO instrument_scores VALUES (?,?,?,?,?,?,?)", (*row, _now(), author))
    return checked


def scores_of(db: sqlite3.Connection, participant: str) -> list[Score]:
    """Return the scores of a participant, oldest first."""
    rows = db.execute(
        "SELECT instrument, date, score, note FROM instrument_scores WHERE participant=? ORDER BY date, recorded_at",
        (participant,),
    )
    return list({(instrument, on): Score(instrument, on, score, note) for instrument, on, score, note in rows}.values())


def _date(text: str) -> str:
    try:
        found = date.fromisoformat(text.strip())
    except ValueError:
        raise StoreError(f"The date must be one such as 2026-03-01, not {text!r}.", bad_input=True) from None
    if found > date.today():
        raise StoreError(f"The date {found} is in the future.", bad_input=True)
    return found.isoformat()


def _now() -> str:
    return datetime.now(UTC).isoformat()

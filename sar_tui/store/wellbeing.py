"""Answers about pain and tiredness, before and after sessions and in pauses."""

import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from typing import Any, Literal

import msgspec

from sar_tui.rules.wellbeing import (
    PAIN_SESSIONS,
    TIRED_SESSIONS,
    Moment,
    PainLimits,
    SessionRatings,
)
from sar_tui.store.counted import LIVE
from sar_tui.store.database import transaction
from sar_tui.store.participants import add

Row = dict[str, Any]
Question = Literal["pain", "place", "fatigue", "advice"]
"""A question, or the ``advice`` not to train, whose answers tell what came of it
(`policies.wellbeing.Advice`).
"""
NOT_SAID = "not said"
"""Answer of a participant who would rather not say."""
IN_PAUSE = "yes"
"""Answer that is stored of each pause for pain or tiredness, before any question."""
_COLUMNS = ("session", "seat", "participant", "moment", "question", "answer", "at")
PAUSES = (
    "WITH given (session, seat, question, at) AS (VALUES (?, ?, ?, ?))"
    " INSERT OR IGNORE INTO wellbeing (session, seat, participant, moment, question, answer, at)"
    f" SELECT session, seat, participant, 'pause', question, '{IN_PAUSE}', at"
    " FROM given JOIN seats USING (session, seat)"
)
"""Statement that stores what was said in a pause: session, seat, question, time."""


def now() -> str:
    """Return the present time as it is stored."""
    return datetime.now(UTC).isoformat()


def save(
    db: sqlite3.Connection,
    participant: str,
    moment: Moment,
    question: Question,
    answer: str,
    *,
    session: str | None = None,
    seat: str = "A",
) -> str:
    """Store an answer at once, and return its time. Raises StoreError.

    Answers before a session have none yet: see `attach`. A new participant is added with the first
    one, because the session may not begin.
    """
    at = now()
    participant = add(db, participant)
    with transaction(db) as connection:
        connection.execute(
            f"INSERT INTO wellbeing ({', '.join(_COLUMNS)}) VALUES (?,?,?,?,?,?,?)",
            (session, seat, participant, moment, question, answer, at),
        )
    return at


def attach(db: sqlite3.Connection, session: str, participants: Sequence[str], since: str) -> None:
    """Give answers that were stored since a time, before the session began, their session. Raises
    StoreError.
    """
    slots = ",".join("?" for _ in participants)
    with transaction(db) as connection:
        connection.execute(
            "UPDATE wellbeing SET session=? WHERE session IS NULL AND at>=? AND participant IN "
            f"({slots})",
            (session, since, *participants),
        )


def of_session(db: sqlite3.Connection, session: str) -> list[Row]:
    """Return the rows of a session, in order."""
    return list(_rows(db.execute(f"{_SELECT} WHERE session=? ORDER BY at, rowid", (session,))))


def by_session(db: sqlite3.Connection, sessions: Sequence[str]) -> dict[str, list[Row]]:
    """Return the rows of some sessions by session; only those of which something is known."""
    found: dict[str, list[Row]] = {}
    wanted = msgspec.json.encode(list(sessions)).decode()
    for row in _rows(
        db.execute(
            f"{_SELECT} WHERE session IN (SELECT value FROM json_each(?)) {_IN_ORDER}", (wanted,)
        )
    ):
        found.setdefault(row["session"], []).append(row)
    return found


def of_participant(db: sqlite3.Connection, participant: str) -> list[Row]:
    """Return the rows of a participant, oldest first; some have no session, as it did not begin."""
    return list(
        _rows(db.execute(f"{_SELECT} WHERE participant=? ORDER BY at, rowid", (participant,)))
    )


def newest_without_session(db: sqlite3.Connection) -> dict[str, list[Row]]:
    """Return by participant what they said before a session that never began, since their newest
    session.
    """
    newest = (
        "SELECT started_at FROM seats CROSS JOIN sessions ON sessions.id=seats.session"
        f" WHERE seats.participant=wellbeing.participant AND {LIVE} ORDER BY seats.rowid DESC "
        "LIMIT 1"
    )
    found: dict[str, list[Row]] = {}
    query = f"{_SELECT} WHERE session IS NULL AND at > coalesce(({newest}), '') {_IN_ORDER}"
    for row in _rows(db.execute(query)):
        found.setdefault(row["participant"], []).append(row)
    return found


def limits_in(parameters: Mapping[str, Any]) -> PainLimits:
    """Return the limits of pain from the parameters of a session; a session without any has the
    usual ones.
    """
    usual = PainLimits()
    return PainLimits(
        parameters.get("pain_limit", usual.highest), parameters.get("pain_rise", usual.rise)
    )


def limits_of(db: sqlite3.Connection, sessions: Sequence[str]) -> dict[str, PainLimits]:
    """Return the limits of pain of some sessions, by session."""
    query = f"SELECT id, {_LIMITS} FROM sessions WHERE id IN (SELECT value FROM json_each(?))"
    wanted = msgspec.json.encode(list(sessions)).decode()
    return {session: PainLimits(*limits) for session, *limits in db.execute(query, (wanted,))}


def ratings(
    rows: Sequence[Row], seat: str = "A", limits: PainLimits | None = None
) -> SessionRatings:
    """Return the ratings of a session from its rows; the last answer of a question counts."""
    found: dict[str, Any] = {"limits": limits} if limits else {}
    told_pain = False
    for row in rows:
        if row["seat"] != seat:
            continue
        if row["question"] == "advice":
            found["advice"] = row["answer"]
            continue
        is_number = row["question"] in ("pain", "fatigue") and row["answer"].isdecimal()
        if row["moment"] != "pause":
            if is_number:
                found[f"{row['question']}_{row['moment']}"] = int(row["answer"])
        elif row["question"] == "pain":
            told_pain = True
            if is_number:
                found["pain_pause"] = max(int(row["answer"]), found.get("pain_pause", 0))
    return SessionRatings(**found, told_pain=told_pain)


def history(db: sqlite3.Connection, participant: str) -> list[SessionRatings]:
    """Return the ratings of a participant's live sessions, oldest first, also of those that did not
    ask.

    Among them is what was said before a session that never began, as pain may be why.
    """
    sessions = db.execute(f"{_LIVE_SESSIONS} ORDER BY seats.rowid", (participant,)).fetchall()
    known = by_session(db, [session for session, *_ in sessions])
    rated = [
        (began, ratings(known.get(session, ()), seat, PainLimits(*limits)))
        for session, seat, began, *limits in sessions
    ]
    return _in_time([*rated, *_not_begun(db, participant)])


def newest_ratings(db: sqlite3.Connection, participant: str) -> list[SessionRatings]:
    """Return as many of the newest ratings, oldest first, as `tell_therapist` looks at; as
    `history`, but sooner.
    """
    found: list[_Dated] = []
    pains, tired = PAIN_SESSIONS + 1, TIRED_SESSIONS
    answered = f"{_LIVE_SESSIONS} AND EXISTS (SELECT 1 FROM wellbeing WHERE session=sessions.id)"
    for session, seat, began, *limits in db.execute(
        f"{answered} ORDER BY seats.rowid DESC", (participant,)
    ):
        rated = ratings(of_session(db, session), seat, PainLimits(*limits))
        found.append((began, rated))
        pains -= rated.pain is not None
        tired -= rated.fatigue_after is not None
        if pains <= 0 and tired <= 0:
            break
    return _in_time([*found[::-1], *_not_begun(db, participant)])


_Dated = tuple[str, SessionRatings]
"""When a session began, or the first answer was given if none did, and its ratings."""


def _not_begun(db: sqlite3.Connection, participant: str) -> Iterator[_Dated]:
    """Yield the ratings before sessions that never began: those of a day together."""
    by_day: dict[str, list[Row]] = {}
    for row in _rows(
        db.execute(f"{_SELECT} WHERE participant=? AND session IS NULL {_IN_ORDER}", (participant,))
    ):
        by_day.setdefault(row["at"][:10], []).append(row)
    for rows in by_day.values():
        yield rows[0]["at"], msgspec.structs.replace(ratings(rows, rows[0]["seat"]), began=False)


def _in_time(rated: Sequence[_Dated]) -> list[SessionRatings]:
    """Return ratings in the order of time."""
    return [ratings for _, ratings in sorted(rated, key=lambda each: each[0] or "")]


_USUAL = PainLimits()
_LIMITS = (
    f"coalesce(json_extract(parameters, '$.pain_limit'), {_USUAL.highest}),"
    f" coalesce(json_extract(parameters, '$.pain_rise'), {_USUAL.rise})"
)
_LIVE_SESSIONS = (
    f"SELECT sessions.id, seats.seat, started_at, {_LIMITS} FROM seats CROSS JOIN sessions ON "
    "sessions.id=seats.session"
    f" WHERE participant=? AND {LIVE}"
)
"""Also of sessions that do not count: pain is pain, whatever became of the session."""
_SELECT = f"SELECT {', '.join(_COLUMNS)} FROM wellbeing"
_IN_ORDER = "ORDER BY at, rowid"


def _rows(cursor: sqlite3.Cursor) -> Iterator[Row]:
    return (dict(zip(_COLUMNS, row, strict=True)) for row in cursor)

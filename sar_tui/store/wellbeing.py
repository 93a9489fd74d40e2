"""Records of pain and tiredness: what was told in a session, and what the rules make of it."""

import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import msgspec

from sar_tui.rules.wellbeing import (
    PAIN_SESSIONS,
    TIRED_SESSIONS,
    PainLimits,
    SessionRatings,
)
from sar_tui.store import records
from sar_tui.store.counted import LIVE
from sar_tui.store.records import Record

PAIN, TIREDNESS = "pain", "tiredness"
KINDS = (PAIN, TIREDNESS)
RATED, TOLD = "rated", "told in a pause"
"""Answers of a participant, beside ``NOT_SAID``: a number, or a key of the pause."""


def of_session(db: sqlite3.Connection, session: str) -> list[Record]:
    """Return the records of a session, in order."""
    return records.listing(db, kinds=KINDS, session=session)


def by_session(db: sqlite3.Connection, sessions: Sequence[str]) -> dict[str, list[Record]]:
    """Return the records of some sessions, by session."""
    return records.of_sessions(db, sessions, KINDS)


def of_participant(db: sqlite3.Connection, participant: str) -> list[Record]:
    """Return the records of a participant, oldest first; some have no session, as it did not
    begin.
    """
    return records.listing(db, kinds=KINDS, participant=participant)


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
    told: Sequence[Record], seat: str = "A", limits: PainLimits | None = None
) -> SessionRatings:
    """Return the ratings of a session from its records; of a moment, the last one counts."""
    found: dict[str, Any] = {"limits": limits} if limits else {}
    told_pain = False
    for record in told:
        if record.seat != seat:
            continue
        content, rating = record.content, record.content.get("rating")
        if advice := content.get("advice"):
            found["advice"] = advice
        if record.moment == "pause":
            if record.kind == PAIN:
                told_pain = True
                if rating is not None:
                    found["pain_pause"] = max(rating, found.get("pain_pause", 0))
        elif rating is not None:
            name = "pain" if record.kind == PAIN else "fatigue"
            found[f"{name}_{record.moment}"] = rating
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
    told = (
        "EXISTS (SELECT 1 FROM records WHERE session=sessions.id"
        f" AND kind IN ('{PAIN}', '{TIREDNESS}'))"
    )
    for session, seat, began, *limits in db.execute(
        f"{_LIVE_SESSIONS} AND {told} ORDER BY seats.rowid DESC", (participant,)
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
    by_day: dict[str, list[Record]] = {}
    for record in records.listing(db, kinds=KINDS, participant=participant, only="without session"):
        by_day.setdefault(record.day, []).append(record)
    for told in by_day.values():
        yield told[0].at, msgspec.structs.replace(ratings(told, told[0].seat), began=False)


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
    f"sessions.id=seats.session WHERE participant=? AND {LIVE}"
)
"""Also of sessions that do not count: pain is pain, whatever became of the session."""

"""Facts of the therapist's day, for each participant: newest sessions, pain, events and visits.

Only the newest rows of each person are read, so that it takes as long after a thousand sessions.
"""

import sqlite3
from collections.abc import Iterable, Mapping, Sequence
from datetime import date, datetime
from pathlib import Path
from typing import NamedTuple

import msgspec

from sar_tui.records.kind import of_group
from sar_tui.rules.attention import (
    STUCK_SESSIONS,
    Course,
    Event,
    PastSession,
    Rated,
    is_this_week,
)
from sar_tui.rules.difficulty import BY_OUTCOME
from sar_tui.rules.policies import DIFFICULTY
from sar_tui.rules.wellbeing import PAIN_SESSIONS
from sar_tui.store import records, results, training_days, wellbeing
from sar_tui.store.counted import COUNTS, LIVE
from sar_tui.store.records import Record
from sar_tui.store.results import Played
from sar_tui.store.sessions import status_now
from sar_tui.store.training_days import UTC_OFFSET, trained_at

_LOOKED_AT = 12
"""Newest sessions of a participant that are looked at, and all others of this week."""
_RATED = PAIN_SESSIONS + 3
"""Newest sessions of which the ratings are looked at, in a course that goes on; some did not ask."""


class DayTotal(msgspec.Struct, frozen=True):
    """The sessions of a day.

    Attributes:
        began: when the first of them began, where it was played.
        attempts: those that were finished. ``minutes``: in them, without the rests between them.
        reached: attempts that reached their goal. ``judged``: those that had one.
    """

    began: datetime
    attempts: int
    minutes: int
    reached: int
    judged: int


class Person(msgspec.Struct, frozen=True):
    """A participant of this site. ``today``: their sessions of today that count; None without
    one.
    """

    code: str
    course: Course
    today: DayTotal | None


class _Session(NamedTuple):
    """A session of a person, as it is stored."""

    code: str
    seat: str
    id: str
    task: str
    status: str
    began: datetime
    programme: int | None
    counts: bool


def read_people(database: sqlite3.Connection, folder: Path, today: date) -> list[Person]:
    """Return this site's participants, first who began a session, or was added, last."""
    added = dict(
        database.execute("SELECT code, created_at FROM participants WHERE site='' ORDER BY code")
    )
    sessions = {code: _newest_sessions(database, folder, code, today) for code in added}
    levels_of, totals = _attempts(database, sessions, today)
    rated = _rated(database, sessions, today)
    events, due = _events(database), training_days.visits_due(database, today)
    versions = _versions(database)
    return [
        Person(
            code,
            Course(
                sessions=[
                    PastSession(
                        day=each.began.date(),
                        task=each.task,
                        status=each.status,
                        counts=each.counts,
                        programme=each.programme,
                        levels=levels_of.get((each.id, each.seat), ()),
                    )
                    for each in sessions[code]
                ],
                rated=rated.get(code, ()),
                events=events.get(code, ()),
                programmes=versions.get(code, {}),
                due=due.get(code),
            ),
            totals.get(code),
        )
        for code in _newest_first(added, sessions)
    ]


_NEWEST = (
    "SELECT seat, sessions.id, task, status, started_at, "
    f"{UTC_OFFSET}, programme, {COUNTS}"
    " FROM seats CROSS JOIN sessions ON sessions.id=seats.session"
    f" WHERE participant=? AND {LIVE} ORDER BY seats.rowid DESC"
)
"""A participant's seats are visited from the newest on; reading ends with the first old session."""


def _newest_sessions(
    database: sqlite3.Connection, folder: Path, code: str, today: date
) -> list[_Session]:
    """Return the newest sessions of a participant, and all of this week, newest first."""
    found: list[_Session] = []
    for seat, id, task, status, began, offset, programme, counts in database.execute(
        _NEWEST, (code,)
    ):
        at = trained_at(began, offset)
        if len(found) >= _LOOKED_AT and not is_this_week(at.date(), today):
            break
        now = status_now(status, id, folder)
        found.append(_Session(code, seat, id, task, now, at, programme, bool(counts)))
    return found


def _newest_first(
    added: Mapping[str, str], sessions: Mapping[str, Sequence[_Session]]
) -> list[str]:
    """Return the codes by the time of the newest session, or of being added."""

    def newest(code: str) -> datetime:
        return max([trained_at(added[code], None), *(each.began for each in sessions[code][:1])])

    return sorted(added, key=newest, reverse=True)


# --- attempts: the levels of the newest sessions, and what was done today


def _attempts(
    database: sqlite3.Connection, sessions: Mapping[str, Sequence[_Session]], today: date
) -> tuple[dict[tuple[str, str], list[int]], dict[str, DayTotal]]:
    """Return the levels of sessions whose level follows the person, by session and seat, and the
    total of today, by participant.
    """
    newest, of_today = [], []
    for own in sessions.values():
        counted = [each for each in own if each.counts]
        of_today += [each for each in counted if each.began.date() == today]
        for task in {each.task for each in counted}:
            newest += [each for each in counted if each.task == task][:STUCK_SESSIONS]
    played = results.attempts_of(database, [each.id for each in {*newest, *of_today}])
    moving = _moving(database, [each.id for each in newest])
    levels = {
        (each.id, each.seat): [attempt.level for attempt in played.get((each.id, each.seat), ())]
        for each in newest
        if each.id in moving
    }
    by_person: dict[str, list[_Session]] = {}
    for each in of_today:
        by_person.setdefault(each.code, []).append(each)
    totals = {
        code: _total([(each, played.get((each.id, each.seat), ())) for each in own])
        for code, own in by_person.items()
    }
    return levels, totals


def _total(played: Sequence[tuple[_Session, Sequence[Played]]]) -> DayTotal:
    attempts = [attempt for _, done in played for attempt in done]
    judged = [attempt.reached for attempt in attempts if attempt.reached is not None]
    return DayTotal(
        began=min(session.began for session, _ in played),
        attempts=len(attempts),
        minutes=round(sum(attempt.seconds for attempt in attempts) / 60),
        reached=sum(judged),
        judged=len(judged),
    )


def _moving(database: sqlite3.Connection, sessions: Sequence[str]) -> set[str]:
    """Return those sessions in which the level followed the person, and could change."""
    query = (
        "SELECT sessions.id, json_extract(parameters, '$.difficulty_policy'),"
        " json_extract(parameters, '$.min_level')=json_extract(parameters, '$.max_level')"
        " FROM json_each(?) AS chosen CROSS JOIN sessions ON sessions.id=chosen.value"
    )
    return {
        id
        for id, name, is_fixed in database.execute(query, (_json(sessions),))
        if (policy := DIFFICULTY.get(name or BY_OUTCOME)) and policy.moves_level and not is_fixed
    }


def _versions(database: sqlite3.Connection) -> dict[str, dict[str, int]]:
    """Return the newest version of each programme, by participant and task."""
    found: dict[str, dict[str, int]] = {}
    for code, task, version in database.execute(
        "SELECT participant, task, max(version) FROM programmes GROUP BY participant, task"
    ):
        found.setdefault(code, {})[task] = version
    return found


# --- pain, tiredness and adverse events


def _rated(
    database: sqlite3.Connection, sessions: Mapping[str, Sequence[_Session]], today: date
) -> dict[str, list[Rated]]:
    """Return the newest ratings of each participant who said something this week, oldest first."""
    not_begun = _not_begun(database, today)
    asked: list[_Session] = []
    for code, own in sessions.items():
        of_week = [each for each in own if is_this_week(each.began.date(), today)]
        if of_week or code in not_begun:
            asked += own[: max(len(of_week), _RATED)]
    told = wellbeing.by_session(database, [each.id for each in asked])
    limits = wellbeing.limits_of(database, [id for id, said in told.items() if _has_pain(said)])
    dated: dict[str, list[tuple[datetime, Rated]]] = not_begun
    for each in asked:
        if said := told.get(each.id):
            rated = wellbeing.ratings(said, each.seat, limits.get(each.id))
            dated.setdefault(each.code, []).append((each.began, Rated(each.began.date(), rated)))
    return {
        code: [rated for _, rated in sorted(own, key=lambda one: one[0])]
        for code, own in dated.items()
    }


def _has_pain(said: Iterable[Record]) -> bool:
    return any(record.kind == wellbeing.PAIN and record.content.get("rating") for record in said)


def _not_begun(
    database: sqlite3.Connection, today: date
) -> dict[str, list[tuple[datetime, Rated]]]:
    """Return what was said this week before sessions that never began, by participant, with its
    time.
    """
    by_day: dict[tuple[str, date], list[Record]] = {}
    for record in records.listing(database, kinds=wellbeing.KINDS, only="without session"):
        day = trained_at(record.at, None).date()
        if is_this_week(day, today):
            by_day.setdefault((record.participant, day), []).append(record)
    found: dict[str, list[tuple[datetime, Rated]]] = {}
    for (code, day), said in by_day.items():
        ratings = msgspec.structs.replace(wellbeing.ratings(said, said[0].seat), began=False)
        found.setdefault(code, []).append((trained_at(said[0].at, None), Rated(day, ratings)))
    return found


def _events(database: sqlite3.Connection) -> dict[str, list[Event]]:
    """Return the adverse events of each participant."""
    found: dict[str, list[Event]] = {}
    for record in records.of_everyone(database, [kind.name for kind in of_group("event")]):
        found.setdefault(record.participant, []).append(
            Event(
                day=date.fromisoformat(record.day),
                severity=str(record.content.get("severity", "")),
                has_outcome="outcome" in record.content,
            )
        )
    return found


def _json(names: Sequence[str]) -> str:
    return msgspec.json.encode(list(names)).decode()

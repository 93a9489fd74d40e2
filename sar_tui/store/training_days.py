"""Days of training, by the time of day where each session was played: a database may hold sessions of
other places, and seasons.
"""

import json
import sqlite3
from datetime import UTC, date, datetime, timedelta, timezone

import msgspec

from sar_tui.rules.limits import Dose
from sar_tui.store.counted import COUNTS

_DAY_S = 86_400

UTC_OFFSET = (
    "(SELECT CASE WHEN json_valid(clock_anchor) THEN json_extract(clock_anchor, '$.utc_offset_s') "
    "END"
    " FROM runs WHERE runs.session=sessions.id ORDER BY run LIMIT 1)"
)
"""Offset of a row of ``sessions``, in s, at the start of its first run; NULL if it was not
recorded.
"""


def utc(now: datetime | None = None) -> str:
    """Return a time as it is stored, in UTC; by default the present."""
    return (now or datetime.now(UTC)).astimezone(UTC).isoformat()


def utc_offset_s(now: datetime | None = None) -> int:
    """Return the offset of local time from UTC at a time, by default the present, in s."""
    offset = (now or datetime.now()).astimezone().utcoffset()
    return round(offset.total_seconds()) if offset else 0


def zone(offset_s: object) -> timezone | None:
    """Return the time zone of an offset from UTC in s; None if it was not recorded, or cannot be
    one.
    """
    if isinstance(offset_s, int) and abs(offset_s) < _DAY_S:
        return timezone(timedelta(seconds=offset_s))
    return None


def trained_at(stamp: str, offset_s: object) -> datetime:
    """Return a UTC stamp of a session in the time of day of the place where it was played.

    Args:
        stamp: as it is stored.
        offset_s: of its run; without one (see `zone`) the time of day is that of this machine.
    """
    return datetime.fromisoformat(stamp).astimezone(zone(offset_s))


# --- what was done on a day


_NS_PER_MINUTE = 60_000_000_000
_ENDED = (
    "SELECT attempts.practice, attempts.trials, attempts.started_ns, attempts.ended_ns, "
    "runs.clock_anchor"
    f" FROM seats JOIN sessions ON sessions.id=seats.session AND sessions.task=? AND {COUNTS}"
    " JOIN attempts ON attempts.session=sessions.id AND attempts.seat=seats.seat"
    " JOIN runs ON runs.session=sessions.id AND runs.run=attempts.run"
    " WHERE seats.participant=? AND json_extract(runs.clock_anchor, '$.utc') >= ?"
)


def done_on_day(db: sqlite3.Connection, participant: str, task: str, now: datetime) -> Dose:
    """Return what was done in live sessions of a task on the day of ``now``.

    An attempt belongs to the day on which it ended, where it was played. Of an interrupted one, the
    time before the interruption is not counted.
    """
    found = Dose()
    since = (now - timedelta(days=2)).astimezone(tz=None).isoformat()
    for practice, trials, started, ended, text in db.execute(
        _ENDED, (task, participant, since[:10])
    ):
        anchor = msgspec.json.decode(text)
        run_began = anchor["clock_ns"]
        at = datetime.fromisoformat(anchor["utc"]) + timedelta(
            microseconds=(ended - run_began) / 1000
        )
        if at.astimezone(zone(anchor.get("utc_offset_s")) or now.tzinfo).date() == now.date():
            began = started if run_began <= started <= ended else run_began
            found = found.plus(
                minutes=max(ended - began, 0) / _NS_PER_MINUTE,
                repetitions=trials,
                is_practice=bool(practice),
            )
    return found


def session_number(database: sqlite3.Connection, participant: str, session: str) -> int:
    """Return the number of a session among those of a participant that count, from 1."""
    (number,) = database.execute(
        f"""SELECT count(*) FROM seats JOIN sessions ON sessions.id=seats.session
        WHERE seats.participant=:participant AND (sessions.id=:session OR {COUNTS}) AND started_at<=
        (SELECT started_at FROM sessions WHERE id=:session)""",
        {"participant": participant, "session": session},
    ).fetchone()
    return int(number)


# --- visits that are due


_NEWEST = 10
"""Sessions stored last among which the last one is: a clock may have been set back in between."""
_PLANNED = f"""
SELECT participant, days, updated_at,
    (SELECT json_array(started_at, {UTC_OFFSET}) FROM
        (SELECT sessions.id, started_at FROM seats CROSS JOIN sessions ON sessions.id=seats.session
            WHERE seats.participant=planned.participant AND sessions.task=planned.task AND {COUNTS}
            ORDER BY seats.rowid DESC LIMIT {_NEWEST}) AS sessions
        ORDER BY started_at DESC LIMIT 1)
FROM (SELECT participant, task, updated_at, json_extract(parameters, '$.days_between_visits') AS days FROM settings
    WHERE json_valid(parameters)) AS planned
WHERE days > 0
"""
"""The newest programmes that plan visits, with the time at which each was saved, and the last
session. ``CROSS``: the seats of a participant are visited from the newest on.
"""


def visits_due(database: sqlite3.Connection, today: date) -> dict[str, date]:
    """Return the day from which a visit of a participant is due, by code, if that is not later than
    today. Of several programmes the first one counts.
    """
    found: dict[str, date] = {}
    for participant, days, saved_at, session in database.execute(_PLANNED):
        last = trained_at(*json.loads(session)) if session else trained_at(saved_at, None)
        if (today - last.date()).days >= days:
            due = last.date() + timedelta(days=days)
            found[participant] = min(due, found.get(participant, due))
    return found

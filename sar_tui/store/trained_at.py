"""The time of day where a session was played: a database may hold sessions of other places, and
seasons.
"""

from datetime import datetime, timedelta, timezone

_DAY_S = 86_400

UTC_OFFSET = (
    "(SELECT CASE WHEN json_valid(clock_anchor) THEN json_extract(clock_anchor, '$.utc_offset_s') "
    "END"
    " FROM runs WHERE runs.session=sessions.id ORDER BY run LIMIT 1)"
)
"""Offset of a row of ``sessions``, in s, at the start of its first run; NULL if it was not
recorded.
"""


def utc_offset_s() -> int:
    """Return the offset of the present local time from UTC, in s."""
    offset = datetime.now().astimezone().utcoffset()
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

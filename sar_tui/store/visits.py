"""Visits that are due: sessions that a programme expects so many days after the last one."""

import sqlite3
from datetime import date, datetime

from sar_tui.store.counted import COUNTS

_PLANNED = f"""
SELECT participant, days, coalesce(
    (SELECT max(started_at) FROM seats JOIN sessions ON sessions.id=seats.session
        WHERE seats.participant=planned.participant AND sessions.task=planned.task AND {COUNTS}),
    updated_at)
FROM (SELECT participant, task, updated_at, json_extract(parameters, '$.days_between_visits') AS days FROM settings
    WHERE json_valid(parameters)) AS planned
WHERE days > 0
"""
"""The newest programmes that plan visits, with the last session, or the time at which the programme was saved."""


def due(database: sqlite3.Connection, today: date) -> set[str]:
    """Return the participants with a programme whose next visit is due today, or was before."""
    return {
        participant
        for participant, days, last in database.execute(_PLANNED)
        if (today - datetime.fromisoformat(last).astimezone().date()).days >= days
    }

"""Visits that are due: sessions that a programme expects so many days after the last one."""

import json
import sqlite3
from datetime import date

from sar_tui.store.counted import COUNTS
from sar_tui.store.trained_at import UTC_OFFSET, trained_at

_PLANNED = f"""
SELECT participant, days, updated_at,
    (SELECT json_array(started_at, {UTC_OFFSET}) FROM seats JOIN sessions ON sessions.id=seats.session
        WHERE seats.participant=planned.participant AND sessions.task=planned.task AND {COUNTS}
        ORDER BY started_at DESC LIMIT 1)
FROM (SELECT participant, task, updated_at, json_extract(parameters, '$.days_between_visits') AS days FROM settings
    WHERE json_valid(parameters)) AS planned
WHERE days > 0
"""
"""The newest programmes that plan visits, with the time at which each was saved, and the last
session.
"""


def due(database: sqlite3.Connection, today: date) -> set[str]:
    """Return the participants with a programme whose next visit is due today, or was before."""
    found = set()
    for participant, days, saved_at, session in database.execute(_PLANNED):
        last = trained_at(*json.loads(session)) if session else trained_at(saved_at, None)
        if (today - last.date()).days >= days:
            found.add(participant)
    return found

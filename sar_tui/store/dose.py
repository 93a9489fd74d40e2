"""Amount of practice of a participant in a task on a day."""

import sqlite3
from datetime import datetime, timedelta

import msgspec

from sar_tui.rules.limits import Dose
from sar_tui.store.counted import COUNTS
from sar_tui.store.trained_at import zone

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

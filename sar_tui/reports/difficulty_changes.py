"""Changes of level and goal in a session, with their reasons, as lines of text."""

import sqlite3

import msgspec

from sar_tui.loop.topics import ATTEMPT_ENDED, GOAL, LEVEL
from sar_tui.model.messages import AttemptEnded, GoalChanged, LevelChanged

_READ = {ATTEMPT_ENDED.name: AttemptEnded, LEVEL.name: LevelChanged, GOAL.name: GoalChanged}


def lines(database: sqlite3.Connection, session: str) -> list[str]:
    """Return a line for each change of level or goal in a session, in order."""
    rows = database.execute(
        "SELECT topic, message FROM events WHERE session=? AND topic IN "
        f"({','.join('?' * len(_READ))}) ORDER BY seq",
        (session, *_READ),
    )
    attempt, found = 0, []
    for topic, text in rows:
        match msgspec.json.decode(text, type=_READ[topic]):
            case AttemptEnded() as ended:
                attempt = ended.attempt
            case LevelChanged() as change:
                found.append(
                    f"After attempt {attempt}: level {change.previous} → {change.level}. "
                    f"{change.why}".rstrip()
                )
            case GoalChanged() as change:
                values = f"{change.previous:.4g} → {change.goal:.4g} {change.unit}".rstrip()
                found.append(f"After attempt {attempt}: goal {values}. {change.why}")
    return found

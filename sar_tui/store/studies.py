"""The studies of a database, by name: for screens that need no more, if there are none."""

import sqlite3


def names(db: sqlite3.Connection) -> list[str]:
    """Return the names of the studies, in the order in which they were frozen."""
    rows = db.execute("SELECT name FROM studies GROUP BY name ORDER BY min(frozen_at), name")
    return [name for (name,) in rows]

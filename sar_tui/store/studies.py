"""The studies of a database, by name: for screens that need no more, if there are none."""

import sqlite3


def names(db: sqlite3.Connection) -> list[str]:
    """Return the names of the studies, in the order in which they were frozen."""
    rows = db.execute("SELECT name FROM studies GROUP BY name ORDER BY min(frozen_at), name")
    return [name for (name,) in rows]


def blind(db: sqlite3.Connection) -> set[str]:
    """Return the names of the studies that are blind in their newest version."""
    newest = "SELECT max(version) FROM studies AS same WHERE same.name=studies.name"
    rows = db.execute(f"SELECT name FROM studies WHERE blind AND version=({newest})")
    return {name for (name,) in rows}

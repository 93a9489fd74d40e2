"""Messages of a session that tables are made of, each with its content; damaged ones are
reported.
"""

import sqlite3
from collections.abc import Iterator
from typing import Any

from sar_tui.export.damage import Damage, is_not_json

_MESSAGES = "SELECT run, at_ns, message FROM events WHERE session=?"
_NUMBERS = """SELECT seq FROM messages JOIN topics ON topics.id=topic
WHERE session_number=(SELECT number FROM session_numbers WHERE id=?) AND name=? ORDER BY seq"""


def messages_of_topic(
    database: sqlite3.Connection, session: str, topic: str, damage: Damage
) -> Iterator[tuple[int, int, dict[str, Any]]]:
    """Yield the run, the time in ns and the content of each message of a topic, in order."""
    try:
        found = database.execute(
            f"{_MESSAGES} AND topic=? ORDER BY seq", (session, topic)
        ).fetchall()
    except sqlite3.OperationalError as error:
        if not is_not_json(error):
            raise
        found = list(_readable(database, session, topic, damage))
    for run, at, message in found:
        if content := damage.object_of("a message", message, topic):
            yield run, at, content


def _readable(
    database: sqlite3.Connection, session: str, topic: str, damage: Damage
) -> Iterator[tuple[Any, ...]]:
    """Yield messages one by one: SQLite gives up all rows of a query for a single one that is
    damaged.
    """
    for (number,) in database.execute(_NUMBERS, (session, topic)).fetchall():
        try:
            yield from database.execute(f"{_MESSAGES} AND seq=?", (session, number)).fetchall()
        except sqlite3.OperationalError as error:
            if not is_not_json(error):
                raise
            damage.note("a message", f"message {number}")

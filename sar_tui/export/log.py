"""Messages that tables are made of, and the runs of the program that they tell."""

import sqlite3
from collections.abc import Callable, Iterator
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


Find = Callable[[object], int | None]

_OF_ACTIONS = (
    "action_center/proposed",
    "arbiter/pending_approval",
    "arbiter/action",
    "arbiter/dropped",
    "arbiter/level_decided",
)


def runs_of_actions(database: sqlite3.Connection, session: str, damage: Damage) -> Find:
    """Return the run of an action by its id: the one in which it was decided, or proposed if it was
    not decided.
    """
    return _single(database, session) or _found(
        database,
        damage,
        "SELECT coalesce(json_extract(message, '$.id'), json_extract(message, '$.proposal.id')), "
        "max(run) FROM events"
        f" WHERE session=? AND topic IN ({', '.join('?' * len(_OF_ACTIONS))}) GROUP BY 1",
        (session, *_OF_ACTIONS),
    )


def runs_of_notes(database: sqlite3.Connection, session: str, damage: Damage) -> Find:
    """Return the run of a note by its ``at_ns``."""
    return _single(database, session) or _found(
        database,
        damage,
        "SELECT coalesce(nullif(json_extract(message, '$.at'), 0), at_ns), run FROM events"
        " WHERE session=? AND topic='operator/note'",
        (session,),
    )


def runs_of_starts(database: sqlite3.Connection, session: str, damage: Damage) -> Find:
    """Return the run in which an attempt began, by its number."""
    return _single(database, session) or _found(
        database,
        damage,
        "SELECT json_extract(message, '$.attempt'), max(run) FROM events"
        " WHERE session=? AND topic='event_handler/attempt_started' GROUP BY 1",
        (session,),
    )


def _single(database: sqlite3.Connection, session: str) -> Find | None:
    """Return what finds the only run of a session; None if it has several. Saves reading the
    messages.
    """
    runs = [run for (run,) in database.execute("SELECT run FROM runs WHERE session=?", (session,))]
    return (lambda _: runs[0]) if len(runs) == 1 else None


def _found(
    database: sqlite3.Connection, damage: Damage, statement: str, values: tuple[str, ...]
) -> Find:
    try:
        return dict(database.execute(statement, values)).get
    except sqlite3.OperationalError as error:
        if not is_not_json(error):
            raise
        damage.note("a message, which would say the run,", "")
        return lambda _: None

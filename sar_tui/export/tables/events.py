"""Events: a row for each message of a session, in order."""

import sqlite3
from collections.abc import Iterator

from sar_tui.export.columns import RUN, SESSION, TO_SESSION, Table, Values, stored


def _rows(database: sqlite3.Connection, session: str) -> Iterator[Values]:
    for row in database.execute(
        "SELECT seq, run, at_ns, topics.name FROM messages JOIN topics ON topics.id=topic"
        " WHERE session_number=(SELECT number FROM session_numbers WHERE id=?) ORDER BY seq",
        (session,),
    ):
        yield (session, *row)


EVENTS = Table(
    name="events",
    title="A message in the program, without its content",
    columns=(
        SESSION,
        stored("messages.seq"),
        RUN,
        stored("messages.at_ns"),
        stored("topics.name"),
    ),
    key=("session", "seq"),
    rows=_rows,
    references=(TO_SESSION,),
)

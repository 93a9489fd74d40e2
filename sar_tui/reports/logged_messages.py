"""Recorded messages of a session, with the run that each belongs to."""

import sqlite3
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import msgspec

from sar_tui.loop.bus import Topic
from sar_tui.model.messages import Message, OperatorChanged, Role, SessionStarted
from sar_tui.store import messages


class LoggedMessage(NamedTuple):
    """Message of a session. ``at``: time of its cascade (ns), comparable only within its run."""

    run: int
    at: int
    message: Message


class Span(NamedTuple):
    """Run of the program on a session, from its start to its last message (ns)."""

    run: int
    began: int
    ended: int


def read(database: sqlite3.Connection, session: str) -> list[LoggedMessage]:
    """Read all messages of a session in order, except sensor samples.

    Raises:
        StoreError: this version of the program cannot read a message.
    """
    return [LoggedMessage(one.run, one.at, one.message) for one in messages.read(database, session)]


def read_topics(
    database: sqlite3.Connection, session: str, topics: Sequence[Topic[Any]]
) -> list[LoggedMessage]:
    """Read the messages of some topics of a session, in order.

    Raises:
        StoreError: this version of the program cannot read a message.
    """
    kinds = {topic.name: topic.type for topic in topics}
    marks = ",".join("?" * len(kinds))
    rows = database.execute(
        "SELECT seq, run, at_ns, topic, message FROM events WHERE session=? AND topic IN "
        f"({marks}) ORDER BY seq",
        (session, *kinds),
    )
    found = []
    for seq, run, at, name, text in rows:
        try:
            found.append(LoggedMessage(run, at, msgspec.json.decode(text, type=kinds[name])))
        except msgspec.MsgspecError as error:
            raise messages.unreadable(session, seq) from error
    return found


def spans(logged: Iterable[LoggedMessage]) -> dict[int, Span]:
    """Return the runs of a session by number. A run begins with its `SessionStarted`."""
    found: dict[int, Span] = {}
    for run, at, message in logged:
        if isinstance(message, SessionStarted):
            found[run] = Span(run, at, at)
        elif run in found:
            found[run] = found[run]._replace(ended=max(found[run].ended, at))
    return found


def peers(logged: Iterable[LoggedMessage], role: Role) -> list[str]:
    """Return the names of those who had a role, in the order in which they joined."""
    changes = (message for _, _, message in logged if isinstance(message, OperatorChanged))
    return list(dict.fromkeys(changed.actor for changed in changes if changed.role == role))

"""Recorded messages of a session, with the run that each belongs to."""

import sqlite3
from collections.abc import Iterable
from typing import NamedTuple

from sar_tui.framework.messages import Message, OperatorChanged, Role, SessionStarted
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

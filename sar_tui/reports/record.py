"""The record of a session, to be reported on: its messages, and the run that each belongs to."""

from collections.abc import Iterable
from typing import NamedTuple

import msgspec
import sqlite_utils

from sar_tui.framework.messages import Message, OperatorChanged, Role, SessionStarted
from sar_tui.framework.topics import ALL
from sar_tui.store.database import StoreError


class Told(NamedTuple):
    """A message of a session. ``at`` (ns) is that of its cascade, and compares within one ``run`` alone."""

    run: int
    at: int
    message: Message


class Span(NamedTuple):
    """A run of the program on a session: from its beginning to the last that was recorded of it, ns."""

    run: int
    began: int
    ended: int


def read(database: sqlite_utils.Database, session: str) -> list[Told]:
    """All messages of a session, in order; samples of sensors are left out.

    Raises:
        StoreError: a message that this version of the program cannot read.
    """
    found = []
    for seq, run, at, name, text in database.execute(
        "SELECT seq, run, at_ns, topic, message FROM events WHERE session=? ORDER BY seq", (session,)
    ):
        try:
            found.append(Told(run, at, msgspec.json.decode(text, type=ALL[name].type)))
        except (KeyError, msgspec.MsgspecError) as error:
            raise StoreError(
                f"Message {seq} of session {session} cannot be read by this version of sar-tui."
            ) from error
    return found


def spans(told: Iterable[Told]) -> dict[int, Span]:
    """The runs of a session, by number. A run begins when the session is started in it."""
    found: dict[int, Span] = {}
    for run, at, message in told:
        if isinstance(message, SessionStarted):
            found[run] = Span(run, at, at)
        elif run in found:
            found[run] = found[run]._replace(ended=max(found[run].ended, at))
    return found


def people(told: Iterable[Told], role: Role) -> list[str]:
    """Who was there in a role, by name, in the order in which they came."""
    changes = (message for _, _, message in told if isinstance(message, OperatorChanged))
    return list(dict.fromkeys(changed.actor for changed in changes if changed.role == role))

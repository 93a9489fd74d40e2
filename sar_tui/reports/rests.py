"""Rests that a participant had to take, as lines of text."""

import sqlite3

import msgspec

from sar_tui.loop.topics import COMMAND, WAITING
from sar_tui.model.messages import SessionCommand, Waiting
from sar_tui.model.units import SECOND

_READ = {WAITING.name: Waiting, COMMAND.name: SessionCommand}


def lines(database: sqlite3.Connection, session: str) -> list[str]:
    """Return a line for each rest of a session, in order: its length, pauses included, and who
    ended it early.
    """
    rows = database.execute(
        "SELECT run, at_ns, topic, message FROM events WHERE session=? AND topic IN (?, ?) ORDER "
        "BY seq",
        (session, *_READ),
    )
    found: list[str] = []
    began: tuple[int, int, int] | None = None
    ended_by = ""
    for run, at, topic, text in rows:
        message = msgspec.json.decode(text, type=_READ[topic])
        if began and began[0] != run:
            began = None
        if isinstance(message, SessionCommand):
            is_end = message.command == "skip" and message.reason != "attempt"
            ended_by = message.actor if is_end and began else ended_by
        elif message.stage == "rest" and began is None:
            began, ended_by = (run, at, message.attempt - 1), ""
        elif began and message.stage not in ("rest", "paused"):
            early = f", ended by the {ended_by}" if ended_by else ""
            found.append(
                f"After attempt {began[2]}: a rest of {(at - began[1]) / SECOND:.0f} s{early}."
            )
            began = None
    return found

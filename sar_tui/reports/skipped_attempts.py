"""Attempts that were left out, or begun again, as lines of text."""

import sqlite3

import msgspec

from sar_tui.loop.topics import COMMAND, WAITING
from sar_tui.model.messages import SessionCommand, Waiting

_READ = {WAITING.name: Waiting, COMMAND.name: SessionCommand}


def lines(database: sqlite3.Connection, session: str) -> list[str]:
    """Return a line for each attempt of a session that was left out, by whom and when, or that
    began again.
    """
    rows = database.execute(
        "SELECT topic, message FROM events WHERE session=? AND topic IN (?, ?) ORDER BY seq",
        (session, *_READ),
    )
    found: list[str] = []
    last = Waiting(what="nothing", stage="instructions")
    left_out: tuple[Waiting, str] | None = None
    restarts = 0
    for topic, text in rows:
        message = msgspec.json.decode(text, type=_READ[topic])
        if isinstance(message, SessionCommand):
            is_skip = message.command == "skip" and message.reason == "attempt"
            left_out = (last, message.actor) if is_skip else None
            continue
        if message.restarts > restarts:
            restarts = message.restarts
            found.append(
                f"Attempt {message.attempt - 1} was interrupted; attempt {message.attempt} began "
                "it again."
            )
        if left_out and message.stage in ("attempt", "review", "answer"):
            at, actor = left_out
            done = (
                f"after {at.trial - 1} of {at.trials} trials"
                if at.trial > 1
                else "before its first trial ended"
            )
            found.append(f"Attempt {at.attempt} was skipped by the {actor}, {done}.")
        last, left_out = message, None
    return found

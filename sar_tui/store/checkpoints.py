"""The last checkpoint of a session in the database."""

import sqlite3
import zlib
from typing import NamedTuple

INSERT = "INSERT OR REPLACE INTO checkpoints (session, seq, program, crc32, state) VALUES (?,?,?,?,?)"


class Checkpoint(NamedTuple):
    """State of a session after the message ``seq``; ``program`` identifies the program and the task that made it."""

    seq: int
    program: str
    state: bytes


def row(session: str, checkpoint: Checkpoint) -> tuple[object, ...]:
    """Return the row of a session's checkpoint, for ``INSERT``."""
    packed = zlib.compress(checkpoint.state, 1)
    return session, checkpoint.seq, checkpoint.program, zlib.crc32(packed), packed


def find(database: sqlite3.Connection, session: str, program: str) -> Checkpoint | None:
    """Return the checkpoint of a session; None if there is none of this program, or it or its messages are damaged."""
    found = database.execute(
        "SELECT seq, crc32, state FROM checkpoints WHERE session=? AND program=? AND seq IN (SELECT seq FROM messages"
        " WHERE session_number=(SELECT number FROM session_numbers WHERE id=checkpoints.session))",
        (session, program),
    ).fetchone()
    if found is None:
        return None
    seq, crc, packed = found
    try:
        return Checkpoint(seq, program, zlib.decompress(packed)) if zlib.crc32(packed) == crc else None
    except zlib.error:
        return None

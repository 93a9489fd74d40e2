"""The participants of a session, by seat."""

import sqlite3


def codes_by_seat(database: sqlite3.Connection, session: str) -> dict[str, str]:
    """Return the participants' codes of a session, by seat."""
    return dict(database.execute("SELECT seat, participant FROM seats WHERE session=?", (session,)))

"""Rows that are stored by hand, as no program stores them."""

import json
import sqlite3


def add_message(
    database: sqlite3.Connection, session: str, seq: int, at: int, topic: str, message: object
) -> None:
    """Store a message of run 1 as an object, or as the text that it is, whether or not it is one of
    its topic.
    """
    text = message if isinstance(message, str) else json.dumps(message)
    database.execute("INSERT OR IGNORE INTO session_numbers (id) VALUES (?)", (session,))
    database.execute("INSERT OR IGNORE INTO topics (name, fields) VALUES (?, '')", (topic,))
    database.execute(
        "INSERT INTO messages (session_number, seq, run, at_ns, topic, message)"
        " SELECT number, ?, 1, ?, topics.id, ? FROM session_numbers, topics"
        " WHERE session_numbers.id=? AND name=? AND fields=''",
        (seq, at, text, session, topic),
    )

"""Messages in the database: as arrays of their values, so that the names of their fields are stored
once a topic.

A row of ``topics`` holds the names and defaults of the fields that messages were written with. The
view ``events`` makes objects of them again; this module does so for the program.
"""

import sqlite3
from collections.abc import Callable, Collection, Iterator, Mapping
from functools import cache
from operator import attrgetter
from typing import Any, NamedTuple

import msgspec
from msgspec.structs import FieldInfo, asdict, fields

from sar_tui.loop.bus import Topic
from sar_tui.loop.topics import ALL, PRESENCE
from sar_tui.model.messages import Message
from sar_tui.store.database import StoreError, explain, transaction
from sar_tui.store.tables import MESSAGES

PRESENCE_ID = 1
"""The number of `PRESENCE` in ``topics``: it is in the condition of an index. Its messages are
stored as objects.
"""

_json = msgspec.json.Encoder()


class StoredMessage(NamedTuple):
    """A message of a session with its number, its run, and the time of its cascade (ns, within its
    run).
    """

    seq: int
    run: int
    at: int
    topic: Topic[Any]
    message: Message


class StoredRow(NamedTuple):
    """A message as it is stored, with the name and the layout of its topic (see `layout`)."""

    seq: int
    run: int
    at: int
    topic: str
    fields: str
    text: str


class Numbers(NamedTuple):
    """The numbers that stand for a session, and for each topic by its name, in one database."""

    session: int
    topics: Mapping[str, int]


# --- the form of messages


@cache
def layout(topic: Topic[Any]) -> str:
    """Return the fields of a topic's messages as JSON, ``[name, default]`` or ``[name]``; empty if
    they are objects.
    """
    if topic is PRESENCE:
        return ""
    return _json.encode(
        [[one.encode_name, *_default(one)] for one in _ordered(topic.type)]
    ).decode()


def _ordered(kind: type[Message]) -> list[FieldInfo]:
    """Return the fields of a message in the order in which they are stored: at the end what is most
    often a default.
    """
    return sorted(fields(kind), key=lambda one: (bool(_default(one)), one.name == "seat"))


def _default(one: FieldInfo) -> list[Any]:
    """Return a list with the default of a field; empty if it has none."""
    if one.default_factory is not msgspec.NODEFAULT:
        return [one.default_factory()]
    return [] if one.default is msgspec.NODEFAULT else [one.default]


@cache
def encoder(topic: Topic[Any]) -> Callable[[Message], str]:
    """Return the function that encodes a topic's messages. Values at the end that are defaults are
    left out.
    """
    if topic is PRESENCE:
        return lambda message: _json.encode(message).decode()
    ordered = _ordered(topic.type)
    names = [one.name for one in ordered]
    get = attrgetter(*names)
    values_of = get if len(names) > 1 else lambda message: (get(message),)
    defaults = [default for one in reversed(ordered) for default in _default(one)]

    def encode(message: Message) -> str:
        values = values_of(message)
        kept = len(values)
        for default in defaults:
            if values[kept - 1] != default:
                break
            kept -= 1
        return _json.encode(values[:kept]).decode()

    return encode


@cache
def _decoder(topic: Topic[Any], stored: str) -> Callable[[str], Message]:
    """Return the function that decodes messages that were stored with the layout ``stored``."""
    kind: type[Message] = topic.type
    if not stored:
        return msgspec.json.Decoder(kind).decode
    if stored == layout(topic):
        decode = msgspec.json.Decoder(_array_like(kind)).decode
        return lambda text: kind(**asdict(decode(text)))
    names = [name for name, *_ in msgspec.json.decode(stored)]
    defaults = {name: default[0] for name, *default in msgspec.json.decode(stored) if default}

    def decode_earlier(text: str) -> Message:
        values = msgspec.json.decode(text, type=list[Any])
        return msgspec.convert(defaults | dict(zip(names, values, strict=False)), kind)

    return decode_earlier


def _array_like(kind: type[Message]) -> type[msgspec.Struct]:
    """Return a type with the fields of a message that is decoded from an array."""

    def as_declared(one: FieldInfo) -> Any:
        if one.default_factory is not msgspec.NODEFAULT:
            return msgspec.field(default_factory=one.default_factory)
        return msgspec.field(default=one.default)

    same = [(one.name, one.type, as_declared(one)) for one in _ordered(kind)]
    return msgspec.defstruct(kind.__name__, same, array_like=True, kw_only=True)


# --- in the database


def numbers(database: sqlite3.Connection, session: str) -> Numbers:
    """Return the numbers of a session and of all topics in a database; those that it lacks are
    stored.

    Raises:
        StoreError: the database cannot be used.
    """
    try:
        if _missing(database, session):
            with transaction(database) as connection:
                return add_numbers(connection, session)
        return add_numbers(database, session)
    except sqlite3.Error as error:
        raise explain(error) from error


def add_numbers(connection: sqlite3.Connection, session: str) -> Numbers:
    """Return the numbers as `numbers` does, in a transaction of the caller."""
    for statement, values in _missing(connection, session):
        connection.execute(statement, values)
    (number,) = connection.execute(
        "SELECT number FROM session_numbers WHERE id=?", (session,)
    ).fetchone()
    known = {
        (name, form): id
        for id, name, form in connection.execute("SELECT id, name, fields FROM topics")
    }
    return Numbers(number, {name: known[name, layout(topic)] for name, topic in ALL.items()})


def _missing(database: sqlite3.Connection, session: str) -> list[tuple[str, tuple[str, ...]]]:
    """Return the statements that store the numbers that a database lacks."""
    known = set(database.execute("SELECT name, fields FROM topics"))
    missing: list[tuple[str, tuple[str, ...]]] = [
        ("INSERT OR IGNORE INTO topics (name, fields) VALUES (?, ?)", (name, layout(topic)))
        for name, topic in ALL.items()
        if (name, layout(topic)) not in known
    ]
    if not database.execute("SELECT 1 FROM session_numbers WHERE id=?", (session,)).fetchone():
        missing.append(("INSERT OR IGNORE INTO session_numbers (id) VALUES (?)", (session,)))
    return missing


def extent(database: sqlite3.Connection, session: str) -> tuple[int, int]:
    """Return the numbers of the first and the last message of a session; 0 if there are none."""
    first, last = database.execute(
        f"SELECT (SELECT min(seq) FROM messages WHERE {_OF_SESSION}),"
        f" (SELECT max(seq) FROM messages WHERE {_OF_SESSION})",
        (session, session),
    ).fetchone()
    return first or 0, last or 0


_OF_SESSION = "session_number=(SELECT number FROM session_numbers WHERE id=?)"


def replace(
    connection: sqlite3.Connection, session: str, seq: int, topic: Topic[Any], message: Message
) -> None:
    """Store another message in place of one with the same number and topic, in a transaction of the
    caller.
    """
    numbers = add_numbers(connection, session)
    connection.execute(
        "UPDATE messages SET topic=?, message=? WHERE session_number=? AND seq=?",
        (numbers.topics[topic.name], encoder(topic)(message), numbers.session, seq),
    )


def count(database: sqlite3.Connection, session: str, until: int) -> int:
    """Return how many messages of a session there are with numbers up to ``until``."""
    (stored,) = database.execute(
        f"SELECT count(*) FROM messages WHERE {_OF_SESSION} AND seq<=?", (session, until)
    ).fetchone()
    return int(stored)


def last(database: sqlite3.Connection, session: str) -> tuple[int, int, int]:
    """Return number, run and time of the last message of a session; number 0, and run 1, if there
    is none.
    """
    found = database.execute(
        f"SELECT seq, run, at_ns FROM messages WHERE {_OF_SESSION} ORDER BY seq DESC LIMIT 1",
        (session,),
    ).fetchone()
    return found or (0, 1, 0)


def copy(
    source: sqlite3.Connection, target: sqlite3.Connection, session: str, *, adds: bool = False
) -> list[int]:
    """Copy the messages of a session to another database, in its transaction; replace what it has
    unless ``adds``.

    The two databases have numbers of their own for sessions and topics.

    Returns:
        The numbers of messages that are damaged, which are not copied: no report could read the
            others then.
    """
    target.execute("INSERT OR IGNORE INTO session_numbers (id) VALUES (?)", (session,))
    (number,) = target.execute(
        "SELECT number FROM session_numbers WHERE id=?", (session,)
    ).fetchone()
    if not adds:
        target.execute("DELETE FROM messages WHERE session_number=?", (number,))
    topics = _sound_topics(source)
    target.executemany(
        "INSERT OR IGNORE INTO topics (name, fields) VALUES (?, ?)", [row[1:] for row in topics]
    )
    known = {row[1:]: row[0] for row in target.execute("SELECT id, name, fields FROM topics")}
    there = {id: known[name, stored] for id, name, stored in topics}
    rows = source.execute(
        "SELECT seq, run, at_ns, topic, CAST(message AS BLOB) FROM messages"
        f" WHERE {_OF_SESSION} ORDER BY seq",
        (session,),
    )
    damaged: list[int] = []

    def sound() -> Iterator[tuple[int, int, int, int, int, str]]:
        for seq, run, at, topic, text in rows:
            if topic in there and _is_json(text):
                yield number, seq, run, at, there[topic], text.decode()
            else:
                damaged.append(seq)

    target.executemany(
        MESSAGES.insert(how="INSERT OR IGNORE"),
        sound(),
    )
    return damaged


def _sound_topics(source: sqlite3.Connection) -> list[tuple[int, str, str]]:
    """Return id, name and fields of the topics that are not damaged."""
    rows = source.execute("SELECT id, CAST(name AS BLOB), CAST(fields AS BLOB) FROM topics")
    return [
        (id, name.decode(), fields.decode())
        for id, name, fields in rows
        if name.isascii() and (not fields or _is_json(fields))
    ]


def _is_json(text: bytes) -> bool:
    try:
        msgspec.json.decode(text)
    except (msgspec.DecodeError, UnicodeDecodeError):
        return False
    return True


def read(database: sqlite3.Connection, session: str) -> Iterator[StoredMessage]:
    """Yield the messages of a session, in order.

    Raises:
        StoreError: this version of the program cannot read a message.
    """
    for seq, run, at, name, stored, text in stored_rows(database, session):
        try:
            topic = ALL[name]
            message = _decoder(topic, stored)(text)
        except (KeyError, TypeError, msgspec.MsgspecError) as error:
            raise unreadable(session, seq) from error
        yield StoredMessage(seq, run, at, topic, message)


def unreadable(session: str, seq: int) -> StoreError:
    """Return the error of a stored message that this version cannot read."""
    return StoreError(
        f"Message {seq} of session {session} cannot be read by this version of sar-tui."
    )


def decoded(row: StoredRow) -> Message:
    """Return the message of a row. Raises KeyError, TypeError or MsgspecError if this version
    cannot read it.
    """
    return _decoder(ALL[row.topic], row.fields)(row.text)


def stored_rows(
    database: sqlite3.Connection,
    session: str,
    after: int = 0,
    topics: Collection[str] | None = None,
) -> Iterator[StoredRow]:
    """Yield the messages of a session as they are stored, in order.

    Args:
        database: only read.
        session: its id.
        after: only messages whose number is above it.
        topics: the names of their topics; None: all.
    """
    known = {
        id: (name, stored)
        for id, name, stored in database.execute("SELECT id, name, fields FROM topics")
    }
    of_topics = ""
    if topics is not None:
        wanted = [str(int(id)) for id, (name, _) in known.items() if name in topics]
        of_topics = f" AND topic IN ({', '.join(wanted)})"
    rows = database.execute(
        "SELECT seq, run, at_ns, topic, message FROM messages"
        f" WHERE {_OF_SESSION} AND seq>?{of_topics} ORDER BY seq",
        (session, after),
    )
    unknown = ("", "")  # a damaged number, whose message cannot be read
    for seq, run, at, topic, text in rows:
        yield StoredRow(seq, run, at, *known.get(topic, unknown), text)

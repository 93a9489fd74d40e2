"""Running SHA-256 of a session's log and of what is stored with it, so that a change by hand shows.

Each group of messages that was stored in one transaction has a row in ``log_hashes``. Its hash is
that of the hash before it, of the hashes of its messages, and of the hashes of the rows ``beside``
them: the facts of the session, runs, sensor streams and blocks of samples, and the time of an end.
The last hash stands in the session's row, too.

This proves that something was changed, not that nothing was: who can write to the file can compute
all hashes anew.
"""

import hashlib
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import msgspec

from sar_tui.store import imu, messages
from sar_tui.store.messages import StoredRow
from sar_tui.store.tables import LOG_HASHES

SET_LAST = "UPDATE sessions SET log_hash=? WHERE id=?"

Entry = list[Any]
"""A row beside the messages, by kind and key: ``["facts"]``, ``["run", 1]``, ``["stream", 1]``,
``["chunk", 1, 2]``; or ``["ended", time]``.
"""

_FACTS = "id, task, theme, started_at, seed, parameters, software, machine, mode, programme"
_RUN = "run, clock_anchor, boot_id, pid, software, machine"
_KEYS = {
    "run": ("runs", ("run",)),
    "stream": ("imu_streams", ("stream",)),
    "chunk": ("imu_chunks", ("stream", "seq")),
}
_json = msgspec.json.Encoder()


class Last(NamedTuple):
    """The last group of a session: its number, the number of its last message, and its hash."""

    number: int
    seq: int
    hash: str


# --- storing


def last(database: sqlite3.Connection, session: str) -> Last | None:
    """Return the last group of a session; None if its hashes were removed."""
    found = database.execute(
        "SELECT number, seq, hash FROM log_hashes WHERE session=? ORDER BY number DESC LIMIT 1",
        (session,),
    ).fetchone()
    return Last(*found) if found else None


def next_group(
    before: Last, session: str, stored: Sequence[StoredRow], beside: Iterable[tuple[Entry, bytes]]
) -> tuple[Last, tuple[Any, ...]]:
    """Return a group of messages with the rows beside them, each with its hash; and the group's
    row.
    """
    entries = list(beside)
    seq = stored[-1].seq if stored else before.seq
    digests = [*map(message_hash, stored), *(digest for _, digest in entries)]
    group = Last(before.number + 1, seq, group_hash(before.hash, digests))
    listed = _json.encode([entry for entry, _ in entries]).decode() if entries else ""
    return group, (session, *group[:2], listed, group.hash)


def begin(connection: sqlite3.Connection, session: str) -> None:
    """Store the first group of a new session, with its facts. Call it in the transaction that
    stores them.
    """
    _store(connection, session, Last(0, 0, ""), [["facts"]])


def extend(connection: sqlite3.Connection, session: str, *beside: Entry) -> None:
    """Store a group with all messages that are in none yet, in a transaction of the caller.

    A session whose hashes were removed gets none, so that this shows.
    """
    if before := last(connection, session):
        _store(connection, session, before, beside)


def _store(
    connection: sqlite3.Connection, session: str, before: Last, beside: Iterable[Entry]
) -> None:
    hashed = [(entry, entry_hash(connection, session, entry)) for entry in beside]
    stored = list(messages.stored_rows(connection, session, before.seq))
    group, row = next_group(before, session, stored, hashed)
    connection.execute(LOG_HASHES.insert(), row)
    connection.execute(SET_LAST, (group.hash, session))


# --- hashes


def group_hash(before: str, digests: Iterable[bytes]) -> str:
    """Return the hash of a group from the hash before it, and the hashes of what is in it."""
    return hashlib.sha256(b"".join((before.encode(), *digests))).hexdigest()


def message_hash(row: StoredRow) -> bytes:
    """Return the hash of a message as it is stored."""
    hashed = _of_topic(row.topic, row.fields).copy()
    hashed.update(f"{row.seq} {row.run} {row.at} {row.text}".encode())
    return bytes(hashed.digest())


@cache
def _of_topic(name: str, fields: str) -> Any:
    return hashlib.sha256(f"{name} {fields} ".encode())


def stream_hash(row: Sequence[Any]) -> bytes:
    """Return the hash of a row of ``imu_streams``, in the order of `imu.STREAM`."""
    return _values_hash("stream", row)


def chunk_hash(row: Sequence[Any]) -> bytes:
    """Return the hash of a row of ``imu_chunks``, in the order of `imu.CHUNK`: the samples are at
    its end.
    """
    return _values_hash("chunk", row[:-1], row[-1])


def end_hash(ended: str) -> bytes:
    """Return the hash of the time of an end."""
    return _values_hash("ended", [ended])


def _values_hash(kind: str, values: Iterable[Any], data: bytes = b"") -> bytes:
    return hashlib.sha256(_json.encode([kind, *map(_as_stored, values)]) + data).digest()


def _as_stored(value: Any) -> Any:
    """Return a value that is the same before it is stored and when it is read: SQLite makes 100.0
    of 100 for a REAL.
    """
    if isinstance(value, bool) or (isinstance(value, float) and value.is_integer()):
        return int(value)
    return value


def entry_hash(database: sqlite3.Connection, session: str, entry: Entry) -> bytes:
    """Return the hash of a row beside the messages as it is in the database now; one that is
    missing has one, too.
    """
    kind, *key = entry
    if kind == "facts":
        return facts_hash(database, session, seats(database, session))
    if kind not in _KEYS:
        return _values_hash(kind, key)
    table, names = _KEYS[kind]
    columns = {"run": _RUN, "stream": ", ".join(imu.STREAM), "chunk": ", ".join(imu.CHUNK)}[kind]
    condition = " AND ".join(f"{name}=?" for name in names)
    found = database.execute(
        f"SELECT {columns} FROM {table} WHERE session=? AND {condition}", (session, *key)
    ).fetchone()
    if found is None:
        return b"missing"
    return chunk_hash(found) if kind == "chunk" else _values_hash(kind, found)


def name_of(entry: Entry) -> str:
    """Return the name of a row beside the messages: "facts", "chunk 1 2"."""
    return " ".join(map(str, entry))


def facts_hash(
    database: sqlite3.Connection, session: str, participants: Mapping[str, str]
) -> bytes:
    """Return the hash of a session's facts with these participants, by seat."""
    row = database.execute(f"SELECT {_FACTS}, study FROM sessions WHERE id=?", (session,))
    *found, study = row.fetchone() or (None,)
    if study is not None:  # without one, the hash is that of earlier releases
        found.append(study)
    return _values_hash("facts", [*found, sorted(participants.items())])


def seats(database: sqlite3.Connection, session: str) -> dict[str, str]:
    """Return the participants of a session, by seat."""
    found = database.execute("SELECT seat, participant FROM seats WHERE session=?", (session,))
    return {str(seat): str(participant) for seat, participant in found}


def entries_there(database: sqlite3.Connection, session: str) -> Iterator[Entry]:
    """Yield the rows beside the messages that a session has."""
    for kind, (table, names) in _KEYS.items():
        listed = ", ".join(names)
        for key in database.execute(
            f"SELECT {listed} FROM {table} WHERE session=? ORDER BY {listed}", (session,)
        ):
            yield [kind, *key]


_KEY_TYPES: dict[str, tuple[type, ...]] = {
    "facts": (), "ended": (str,), "run": (int,), "stream": (int,), "chunk": (int, int),
}  # fmt: skip


def entries(beside: str) -> list[Entry]:
    """Return the rows beside the messages of a group as ``log_hashes.beside`` has them; damaged
    ones as ``damaged``.
    """
    try:
        found = msgspec.json.decode(beside, type=list[list[Any]]) if beside else []
    except msgspec.DecodeError:
        return [["damaged"]]
    return [entry if _is_entry(entry) else ["damaged"] for entry in found]


def _is_entry(entry: list[Any]) -> bool:
    if not entry or not isinstance(entry[0], str) or entry[0] not in _KEY_TYPES:
        return False
    return tuple(type(part) for part in entry[1:]) == _KEY_TYPES[entry[0]]

"""Versions of a record that contradict each other: one is in the tables, the others are kept aside.

Every database chooses the same one, so that the order of merges makes no difference.
"""

import hashlib
import sqlite3
import zlib
from collections.abc import Callable, Mapping
from typing import Any, Literal

import msgspec

from sar_tui.store.merge.people import People, in_full
from sar_tui.store.sites import OF_SITES

Kind = Literal["session", "programme", "record"]
Content = dict[str, list[dict[str, Any]]]
"""Rows of a record by table, in the order in which they were stored; codes and sites are in
full.
"""


_MOST_BYTES = 1 << 30
"""Bytes of a version: more than those of a session of some hours with two sensors."""


class Conflict(msgspec.Struct, frozen=True):
    """A version of a record that is kept aside.

    Attributes:
        key: of the record, in words: the session's id; or participant, task and version of a
            programme.
        digest: SHA-256 of the content.
    """

    kind: str
    key: str
    digest: str


def encoded(content: Content) -> bytes:
    """Return a content as bytes that are the same in every database."""
    return msgspec.msgpack.encode(content, order="deterministic")


def digest(content: Content) -> str:
    """Return the SHA-256 of a content, whatever the order of its rows."""
    in_order = {
        table: sorted(msgspec.msgpack.encode(row, order="deterministic") for row in rows)
        for table, rows in content.items()
    }
    return hashlib.sha256(msgspec.msgpack.encode(in_order, order="deterministic")).hexdigest()


def listing(db: sqlite3.Connection) -> list[Conflict]:
    """Return all versions that are kept aside."""
    return [
        Conflict(*row)
        for row in db.execute("SELECT kind, key, digest FROM conflicts ORDER BY kind, key, digest")
    ]


def contents(db: sqlite3.Connection, schema: str, kind: Kind, key: str) -> list[Content]:
    """Return the versions of a record that are kept aside."""
    found = db.execute(
        f"SELECT content FROM {schema}.conflicts WHERE kind=? AND key=?", (kind, key)
    ).fetchall()
    return [decoded(content) for (content,) in found]


def decoded(packed: bytes) -> Content:
    """Return a version from the bytes that are stored. Raises ValueError if they are none, or are
    too large.
    """
    unpacking = zlib.decompressobj()
    try:
        unpacked = unpacking.decompress(packed, _MOST_BYTES)
        if not unpacking.eof:
            raise ValueError("It is cut off, or larger than any session.")
        return msgspec.msgpack.decode(unpacked, type=Content)
    except (zlib.error, TypeError, msgspec.MsgspecError) as error:
        raise ValueError(str(error)) from error


def keep(db: sqlite3.Connection, schema: str, kind: str, key: str, content: Content) -> None:
    """Keep a version aside, unless it is there."""
    row = (kind, key, digest(content), zlib.compress(encoded(content)))
    db.execute(f"INSERT OR IGNORE INTO {schema}.conflicts VALUES (?,?,?,?)", row)


def drop(db: sqlite3.Connection, kind: Kind, key: str, digest: str) -> None:
    """Keep a version aside no longer: it is in the tables now, or another one extends it."""
    db.execute(
        "DELETE FROM main.conflicts WHERE kind=? AND key=? AND digest=?", (kind, key, digest)
    )


def rename(db: sqlite3.Connection, schema: str, people: People) -> None:
    """Give the versions that are kept aside the names of persons who are known as the same now."""
    for kind, key, old, packed in db.execute(
        f"SELECT kind, key, digest, content FROM {schema}.conflicts"
    ).fetchall():
        named = _with_codes(decoded(packed), lambda table, code: _in_words(people, table, code))
        new_key = key if kind == "session" else key_of(kind, named)
        if (digest(named), new_key) != (old, key):
            db.execute(
                f"DELETE FROM {schema}.conflicts WHERE kind=? AND key=? AND digest=?",
                (kind, key, old),
            )
            keep(db, schema, kind, new_key, named)


_KEYS: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "programme": ("programmes", ("participant", "task", "version")),
    "record": ("records", ("id", "version")),
}


def is_record(kind: str, content: Content) -> bool:
    """Return True if a content is one row of the table of its kind, with the columns of its key."""
    table, columns = _KEYS.get(kind, ("", ()))
    return (
        content.keys() == {table}
        and len(content[table]) == 1
        and set(columns) <= content[table][0].keys()
    )


def key_of(kind: str, content: Content) -> str:
    """Return the key of a record, in words."""
    table, columns = _KEYS[kind]
    (row,) = content[table]
    return " ".join(str(row[column]) for column in columns)


def in_words(content: Content, people: People) -> Content:
    """Return rows of the main database with codes and sites in full."""
    named = _with_codes(
        content, lambda table, code: _in_words(people, table, in_full(code, people.own))
    )
    for row in named.get("records", ()):
        row["id"] = in_full(row["id"], people.own)
    return {
        table: [_with_site(table, row, "", people.own) for row in rows]
        for table, rows in named.items()
    }


def as_stored(content: Content, people: People) -> Content:
    """Return rows with the codes and sites by which the main database stores them."""

    def stored(table: str, code: str) -> str:
        return people.shortened(code) if table == "programmes" else people.stored(code)

    named = _with_codes(content, stored)
    for row in named.get("records", ()):
        row["id"] = people.shortened(row["id"])
    return {
        table: [_with_site(table, row, people.own, "") for row in rows]
        for table, rows in named.items()
    }


def _in_words(people: People, table: str, code: str) -> str:
    return code if table == "programmes" else people.name(code)


def _with_codes(content: Content, code: Callable[[str, str], str]) -> Content:
    return {
        table: [{**row, "participant": code(table, row["participant"])} if "participant" in row else {**row}
                for row in rows]
        for table, rows in content.items()
    }  # fmt: skip


def _with_site(table: str, row: dict[str, Any], old: str, new: str) -> dict[str, Any]:
    return {**row, "site": new} if table in OF_SITES and row["site"] == old else row

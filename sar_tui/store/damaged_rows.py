"""Rows that are damaged, as SQL conditions: `integrity` counts them, and `repair` moves them
aside.
"""

import sqlite3
import zlib
from collections.abc import Iterator
from functools import cache
from typing import Literal, NamedTuple

import msgspec

from sar_tui.store.tables import ADDED_LATER, MESSAGES, TABLES, Table, with_column

Kind = Literal["file", "orphan", "gap", "samples", "text", "log", "rows"]
"""``file``: its pages are damaged, or its views are not the program's. ``orphan``: rows that belong
to nothing. ``gap``: numbers that are missing in a row of events, attempts or trials. ``samples``: a
block of a sensor's samples. ``text``: characters, or JSON. ``log``: a session's log is not as its
hashes have it. ``rows``: rows are not as they follow from the log.
"""

_OF_SESSION = "(SELECT id FROM session_numbers WHERE number=session_number)"
_OWNERS = ("session", "id", "participant", "code")
"""Columns that tell whose a row is, the first one that a table has."""
_LAYOUT = (
    "(SELECT layout FROM imu_streams AS s WHERE s.session=imu_chunks.session AND "
    "s.stream=imu_chunks.stream)"
)


class Damage(NamedTuple):
    """Rows of a table that are damaged in the same way.

    ``condition``, ``where`` and ``words`` are SQL on the table: true if a row is damaged; the
    session or participant it is of; a sentence on the rows that have the same ``where`` and
    ``part``. ``reason``: why, for all rows.
    """

    kind: Kind
    table: str
    reason: str
    condition: str
    where: str
    words: str
    part: str = "NULL"


def damages(database: sqlite3.Connection) -> list[Damage]:
    """Return all ways in which rows can be damaged. The connection is given the functions that they
    need.
    """
    database.create_function("damaged_text", -1, _is_no_text, deterministic=True)
    database.create_function("damaged_block", 4, _is_damaged, deterministic=True)
    database.create_function("sample_size", 1, _size, deterministic=True)
    return [*_orphans(), *_samples(), *_json(), *_texts()]


def _orphans() -> Iterator[Damage]:
    yield _orphan(
        "sessions", "sessions without a seat", "id NOT IN (SELECT session FROM seats)", "id"
    )
    yield _orphan(
        "session_numbers", "events without a session", "id NOT IN (SELECT id FROM sessions)", "id"
    )
    yield _orphan(
        "messages",
        "events without a number of their session",
        "session_number NOT IN (SELECT number FROM session_numbers)",
        "session_number",
    )
    yield _orphan(
        "messages", "events without a topic", "topic NOT IN (SELECT id FROM topics)", _OF_SESSION
    )
    yield _orphan("imu_chunks", "samples without their stream", f"{_LAYOUT} IS NULL", "session")
    for table in with_column("session"):
        lost = "session NOT IN (SELECT id FROM sessions)"
        lost = (
            f"session IS NOT NULL AND {lost}"
            if table in ADDED_LATER
            else f"{lost} OR session IS NULL"
        )
        yield _orphan(table, f"{table} without a session", lost, "session")


def _orphan(table: str, reason: str, condition: str, where: str) -> Damage:
    return Damage("orphan", table, reason, condition, where, f"'There are {reason}.'")


def _samples() -> Iterator[Damage]:
    yield Damage(
        "samples",
        "imu_streams",
        "a layout of samples that cannot be read",
        "NOT sample_size(layout)",
        "session",
        "'The layout of sensor stream ' || stream || ' cannot be read.'",
        "stream",
    )
    yield Damage(
        "samples",
        "imu_chunks",
        "a damaged block of samples",
        f"damaged_block(data, n, crc32, {_LAYOUT})",
        "session",
        "'Block ' || seq || ' of sensor stream ' || stream || ' is damaged.'",
        "stream || '/' || seq",
    )


def _json() -> Iterator[Damage]:
    for table in TABLES.values():
        for name in table.of_type("json"):
            source = f"{table.name}.{name}"
            wrong = (
                f"CASE typeof({name}) WHEN 'null' THEN 0 WHEN 'text' THEN NOT "
                f"json_valid({name}) ELSE 1 END"
            )
            told = f"count(*) || ' of the texts {source} cannot be read.'"
            reason = f"a text {source} that cannot be read"
            yield Damage("text", table.name, reason, wrong, _owner(table), told)


def _texts() -> Iterator[Damage]:
    for name, table in sorted(TABLES.items()):
        texts = [f"CAST({each} AS BLOB)" for each in table.of_type("string", "datetime", "json")]
        if texts:
            yield Damage(
                "text",
                name,
                f"characters in {name} that cannot be read",
                f"damaged_text({', '.join(texts)})",
                _owner(table),
                f"count(*) || ' of the rows of {name} have characters that cannot be read.'",
            )


def _owner(table: Table) -> str:
    """Return the SQL of the session or participant that a row is of."""
    if table is MESSAGES:
        return _OF_SESSION
    return next((name for name in _OWNERS if name in table.names), "''")


def _is_no_text(*texts: bytes | None) -> bool:
    try:
        for text in texts:
            if text:
                text.decode()
    except UnicodeDecodeError:
        return True
    return False


def _is_damaged(data: object, count: object, crc: object, layout: str | bytes | None) -> bool:
    """Return True if the samples of a block are damaged. A layout that cannot be read is not the
    block's fault.
    """
    if not isinstance(data, bytes) or not isinstance(count, int) or zlib.crc32(data) != crc:
        return True
    size = _size(layout)
    return bool(size) and len(data) != count * size


@cache
def _size(layout: str | bytes | None) -> int:
    """Return the bytes of a sample; 0 if its layout cannot be read."""
    import numpy as np

    try:
        return np.dtype(
            [tuple(_tuples(field)) for field in msgspec.json.decode(layout or b"")]
        ).itemsize
    except (TypeError, ValueError, msgspec.DecodeError):
        return 0


def _tuples(field: list[object]) -> Iterator[object]:
    return (tuple(part) if isinstance(part, list) else part for part in field)

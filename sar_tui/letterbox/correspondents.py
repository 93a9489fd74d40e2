"""Stored facts of the other computers, and of the letters to and from them."""

import secrets
import sqlite3
from collections.abc import Iterable, Iterator
from datetime import UTC, datetime
from typing import Any, Literal

import msgspec

from sar_tui.letterbox.contents import Contents
from sar_tui.letterbox.sealing import PublicKeys, Ranges
from sar_tui.store.database import StoreError, read_json, store
from sar_tui.store.tables import CORRESPONDENTS, LETTERS

State = Literal["invited", "joined", "revoked", "declined"]
Direction = Literal["out", "in"]


class Correspondent(msgspec.Struct, frozen=True, kw_only=True):
    """The computer at the other end: a row of ``correspondents``."""

    id: str
    participant: str
    number: int = 1
    state: State = "invited"
    verify_key: bytes | None = None
    seal_key: bytes | None = None
    invitation: str = ""
    invited_at: str
    expires_at: str
    heard_at: str = ""
    least_number: int = 1
    owes_answer: int = 0
    wanted: tuple[int, ...] = ()
    void: Ranges = ()
    device: dict[str, Any] = {}
    notice: str = ""

    @property
    def name(self) -> str:
        """The person and the number of their computer, such as P07/2; the first has none."""
        return self.participant if self.number == 1 else f"{self.participant}/{self.number}"

    @property
    def keys(self) -> PublicKeys:
        """Its public keys. Raises StoreError: they are not known yet."""
        if self.verify_key is None or self.seal_key is None:
            raise StoreError(f"Nothing was heard of the computer of {self.name} yet.")
        return PublicKeys(self.verify_key, self.seal_key)


class Sent(msgspec.Struct, frozen=True, kw_only=True):
    """A letter, as it is stored: a row of ``letters``, without what was sealed."""

    number: int
    state: str
    at: str
    put_at: str
    seen_at: str
    file: str
    digest: str
    size: int | None
    contents: Contents


def utc_now() -> str:
    """Return the present time, UTC."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def new_id() -> str:
    """Return a random id of a correspondent."""
    return secrets.token_hex(8)


# --- correspondents


def correspondents(db: sqlite3.Connection) -> list[Correspondent]:
    """Return all, by participant and number."""
    names = CORRESPONDENTS.names
    rows = db.execute(
        f"SELECT {', '.join(names)} FROM correspondents ORDER BY participant, number, invited_at"
    ).fetchall()
    return [_correspondent(dict(zip(names, row, strict=True))) for row in rows]


def _correspondent(row: dict[str, Any]) -> Correspondent:
    row |= {name: read_json(row[name]) for name in ("wanted", "void", "device")}
    try:
        return msgspec.convert(row, Correspondent)
    except msgspec.ValidationError as error:
        raise StoreError(f"The table of correspondents is damaged: {error}.") from error


def add(db: sqlite3.Connection, new: Correspondent) -> None:
    """Store a new one, in a transaction of the caller."""
    store(db, CORRESPONDENTS, **msgspec.structs.asdict(new))


def change(db: sqlite3.Connection, id: str, **values: Any) -> None:
    """Change columns of one, in a transaction of the caller."""
    given = {
        name: msgspec.json.encode(value).decode() if CORRESPONDENTS[name].type == "json" else value
        for name, value in values.items()
    }
    listed = ", ".join(f"{name}=?" for name in given)
    db.execute(f"UPDATE correspondents SET {listed} WHERE id=?", [*given.values(), id])


# --- letters


def letters(db: sqlite3.Connection, id: str, direction: Direction) -> list[Sent]:
    """Return the letters to or from a correspondent, by number."""
    rows = db.execute(
        "SELECT number, state, at, put_at, seen_at, file, digest, length(sealed), contents FROM "
        "letters WHERE correspondent=? AND direction=? ORDER BY number",
        (id, direction),
    ).fetchall()
    return [
        Sent(
            number=number, state=state, at=at, put_at=put_at, seen_at=seen_at, file=file,
            digest=digest, size=size, contents=read_json(contents),
        )
        for number, state, at, put_at, seen_at, file, digest, size, contents in rows
    ]  # fmt: skip


def contents_in_order(db: sqlite3.Connection, id: str) -> list[Contents]:
    """Return what the letters to and from a correspondent brought, in the order in which they were
    stored.
    """
    rows = db.execute(
        "SELECT contents FROM letters WHERE correspondent=? AND state<>'void' ORDER BY rowid", (id,)
    ).fetchall()
    return [read_json(contents) for (contents,) in rows]


def add_letter(db: sqlite3.Connection, id: str, direction: Direction, **values: Any) -> None:
    """Store a letter, in a transaction of the caller."""
    store(db, LETTERS, correspondent=id, direction=direction, **values)


def set_state(
    db: sqlite3.Connection, id: str, numbers: Iterable[int], state: str, *, before: str
) -> None:
    """Change the state of letters from here that have another one, and drop what was sealed."""
    db.executemany(
        "UPDATE letters SET state=?, sealed=NULL WHERE correspondent=? AND direction='out' AND "
        "number=? AND state=?",
        [(state, id, number, before) for number in numbers],
    )


def mark_seen(db: sqlite3.Connection, participant: str) -> bool:
    """Note that a person looked at what the letters from a participant's computers brought; return
    True if something of it was not looked at before. In a transaction of the caller.
    """
    changed = db.execute(
        "UPDATE letters SET seen_at=? WHERE direction='in' AND state='taken' AND seen_at='' AND "
        "contents<>'{}' AND correspondent IN (SELECT id FROM correspondents WHERE participant=?)",
        (utc_now(), participant),
    ).rowcount
    if changed:
        db.execute(
            "UPDATE correspondents SET owes_answer=1 WHERE participant=? AND state='joined'",
            (participant,),
        )
    return changed > 0


# --- ranges of numbers


def ranges(numbers: Iterable[int]) -> Ranges:
    """Return numbers as ranges, first and last."""
    found: list[tuple[int, int]] = []
    for number in sorted(set(numbers)):
        if found and found[-1][1] == number - 1:
            found[-1] = (found[-1][0], number)
        else:
            found.append((number, number))
    return tuple(found)


def within(number: int, given: Ranges) -> bool:
    """Return True if a number is in one of some ranges."""
    return any(first <= number <= last for first, last in given)


def missing(numbers: Iterable[int], void: Ranges = ()) -> list[int]:
    """Return the numbers from 1 to the largest that are not there and not void; the first 1000."""
    found: list[int] = []
    last = 0
    for first, end in ranges([*numbers, *_numbers(void)]):
        found += range(last + 1, min(first, last + 1 + _MOST_MISSING - len(found)))
        last = end
    return found


_MOST_MISSING = 1000


def _numbers(given: Ranges) -> Iterator[int]:
    """Yield the numbers of ranges, at most some thousands."""
    for first, last in given:
        yield from range(first, min(last, first + 10_000) + 1)

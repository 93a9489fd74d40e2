"""Programmes: the settings of a participant for a task, as versions that are added and never
changed.
"""

import sqlite3
from datetime import datetime
from typing import Any

import msgspec

from sar_tui.model.language import Sentence
from sar_tui.store.database import StoreError, read_json, store, transaction
from sar_tui.store.participants import check_own
from sar_tui.store.people_events import check_may_record
from sar_tui.store.tables import PROGRAMMES
from sar_tui.store.texts import check_text
from sar_tui.store.training_days import utc

LONGEST_TEXT = 500
"""Largest number of characters of a reason or an author."""


class Programme(msgspec.Struct, frozen=True):
    """A version of the settings of a participant for a task.

    Attributes:
        parameters: only the values that differ from the task's defaults.
        theme: name of the theme.
        version: 1, 2, …; 0 if nothing was saved yet.
        created_at: when it was saved (UTC, ISO 8601).
        author: who saved it.
        reason: why.
    """

    parameters: dict[str, Any] = {}
    theme: str = "calm"
    version: int = 0
    created_at: str = ""
    author: str = ""
    reason: str = ""


class Superseded(StoreError):
    """Another version was saved meanwhile, which is ``newest``. Nothing was saved."""

    def __init__(self, participant: str, newest: Programme) -> None:
        why = ": ".join(filter(None, (newest.author, newest.reason)))
        told = Sentence(
            "The programme of {who} was changed meanwhile: version {version} ({why}). Nothing was "
            "saved."
            if why
            else "The programme of {who} was changed meanwhile: version {version}. Nothing was "
            "saved.",
            who=participant,
            version=newest.version,
            why=why,
        )
        super().__init__(told, bad_input=True)
        self.newest = newest


_COLUMNS = "parameters, theme, version, created_at, author, reason"
_OF = f"SELECT {_COLUMNS} FROM programmes WHERE participant=? AND task=?"


def newest(db: sqlite3.Connection, participant: str, task: str) -> Programme:
    """Return the newest version of a programme, or the defaults with version 0."""
    row = db.execute(f"{_OF} ORDER BY version DESC LIMIT 1", (participant, task)).fetchone()
    return _programme(row) if row else Programme()


def last_saved(db: sqlite3.Connection, participant: str) -> Programme:
    """Return the programme of any task that was saved last; the defaults if there is none."""
    query = (
        f"SELECT {_COLUMNS} FROM programmes WHERE participant=? ORDER BY created_at DESC LIMIT 1"
    )
    row = db.execute(query, (participant,)).fetchone()
    return _programme(row) if row else Programme()


def versions(db: sqlite3.Connection, participant: str, task: str) -> list[Programme]:
    """Return all versions of a programme, the oldest first."""
    return [_programme(row) for row in db.execute(f"{_OF} ORDER BY version", (participant, task))]


def find(db: sqlite3.Connection, participant: str, task: str, version: int) -> Programme:
    """Return one version of a programme.

    Raises:
        StoreError: there is no such version.
    """
    row = db.execute(f"{_OF} AND version=?", (participant, task, version)).fetchone()
    if row is None:
        raise StoreError(
            f"The programme of {participant} for {task} has no version {version}. "
            f"`sar-tui programme history {participant}` lists them.",
            bad_input=True,
        )
    return _programme(row)


def tasks(db: sqlite3.Connection, participant: str) -> list[str]:
    """Return the tasks for which a participant has a programme, sorted."""
    rows = db.execute(
        "SELECT DISTINCT task FROM programmes WHERE participant=? ORDER BY task", (participant,)
    )
    return [task for (task,) in rows]


def save(
    db: sqlite3.Connection,
    participant: str,
    task: str,
    changed: Programme,
    *,
    after: int,
    author: str = "",
    reason: str = "",
    now: datetime | None = None,
) -> Programme:
    """Save the parameters and theme of ``changed`` as the next version, and return it.

    If they equal those of the newest version, that one is returned and nothing is saved.

    Args:
        after: the version that was changed; 0 if there was none.
        author, reason: who changed it, and why.
        now: when; None for the present.

    Raises:
        Superseded: another version was saved since ``after``.
        StoreError: the participant is of another site, or has withdrawn, a text has control
            characters, or the disk cannot write; nothing was saved.
    """
    check_own(participant)
    check_may_record(db, [participant])
    author, reason = (check_text(f"The {name}", text[:LONGEST_TEXT], LONGEST_TEXT)
                      for name, text in (("author", author), ("reason", reason)))  # fmt: skip
    parameters = msgspec.json.encode(changed.parameters)
    with transaction(db) as connection:
        last = newest(connection, participant, task)
        if last.version != after:
            raise Superseded(participant, last)
        as_stored = msgspec.json.decode(parameters)  # with lists instead of tuples
        if after and (as_stored, changed.theme) == (last.parameters, last.theme):
            return last
        saved = Programme(
            parameters=as_stored,
            theme=changed.theme,
            version=after + 1,
            created_at=utc(now),
            author=author,
            reason=reason,
        )
        store(
            connection,
            PROGRAMMES,
            participant=participant,
            task=task,
            **msgspec.structs.asdict(saved),
        )
    return saved


def _programme(row: tuple[str, str, int, str, str, str]) -> Programme:
    return Programme(read_json(row[0]), *row[1:])

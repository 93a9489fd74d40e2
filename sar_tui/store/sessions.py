"""Sessions in the database: creates, continues and reads them."""

import math
import os
import secrets
import sqlite3
from collections.abc import Callable, Iterator, Mapping, Sequence
from datetime import datetime
from functools import lru_cache
from heapq import merge
from pathlib import Path
from typing import Any, Literal

import msgspec

from sar_tui.loop.bus import Record
from sar_tui.loop.clock import host_now
from sar_tui.loop.nodes.memory import best_key
from sar_tui.loop.task import Task
from sar_tui.loop.topics import SWITCH
from sar_tui.model.messages import AttemptEnded
from sar_tui.model.session_mode import SessionMode
from sar_tui.model.study_place import StudyPlace
from sar_tui.rules.parameters import TaskParameters, fields
from sar_tui.store import imu, log_hashes, messages
from sar_tui.store.counted import COUNTS
from sar_tui.store.database import StoreError, read_json, store, transaction
from sar_tui.store.locks import is_held
from sar_tui.store.tables import RUNS, SEATS, SESSIONS, TABLES, Type
from sar_tui.store.training_days import UTC_OFFSET, trained_at, utc, utc_offset_s

Row = dict[str, Any]

Table = Literal["attempts", "trials", "actions", "runs", "imu_streams", "seats", "answers"]


def new_id() -> str:
    """Return a random id for a session."""
    return secrets.token_hex(5)


def create(
    db: sqlite3.Connection,
    session: str,
    *,
    task: str,
    theme: str,
    participant: str,
    seed: int,
    parameters: object,
    software: object,
    machine: object,
    mode: SessionMode,
    partner: str = "",
    programme: int | None = None,
    study: StudyPlace | None = None,
    now: datetime | None = None,
) -> None:
    """Store a new session and the seats of its participants.

    Other programs see it from then on, so its lock must already be held.

    Args:
        session: an id from ``new_id``.
        partner: the code of the participant at seat B, if there is one.
        programme: the version of the participant's programme; None if there is none.
        study: its place in a study; None if it is of none.
        now: when it begins; None for the present.
    """
    with transaction(db) as connection:
        store(
            connection,
            SESSIONS,
            id=session,
            task=task,
            theme=theme,
            status="running",
            started_at=utc(now),
            seed=seed,
            parameters=parameters,
            software=software,
            machine=machine,
            mode=mode,
            programme=programme,
            **({"study": study} if study else {}),
        )
        store(connection, SEATS, session=session, seat="A", participant=participant)
        if partner:
            store(connection, SEATS, session=session, seat="B", participant=partner)
        log_hashes.begin(connection, session)


def begin_run(
    db: sqlite3.Connection,
    session: str,
    *,
    software: object,
    machine: object,
    clock_ns: int | None = None,
    now: datetime | None = None,
) -> int:
    """Store a run of this program on a session, and return its number (1, 2, …).

    Args:
        clock_ns: the present time of the session's clock; None if it is the host's.
        now: the time of day then; None for the present.
    """
    at = host_now() if clock_ns is None else clock_ns
    anchor = {"clock_ns": at, "utc": utc(now), "utc_offset_s": utc_offset_s(now)}
    with transaction(db) as connection:
        (run,) = connection.execute(
            "SELECT coalesce(max(run), 0) + 1 FROM runs WHERE session=?", (session,)
        ).fetchone()
        store(
            connection,
            RUNS,
            session=session,
            run=run,
            clock_anchor=anchor,
            boot_id=_boot_id(),
            pid=os.getpid(),
            software=software,
            machine=machine,
        )
        connection.execute(
            "UPDATE sessions SET status='running', ended_at=NULL WHERE id=?", (session,)
        )
        log_hashes.extend(connection, session, ["run", run])
    return int(run)


def best(
    db: sqlite3.Connection, participant: str, task: Task, *, without: str = ""
) -> dict[str, float]:
    """Return a participant's best results in a task over live sessions that count, except
    ``without``, by `best_key`.

    Levels can be compared only between sessions with the same version of the task, and the same
    values of the parameters that the task itself declares. Practice attempts and attempts below the
    minimum accuracy do not count.
    """
    metric = task.metric
    kind = type(task.parameters)
    own = {field.name for field in fields(kind)} - {field.name for field in fields(TaskParameters)}
    present = msgspec.json.decode(msgspec.json.encode(task.parameters))
    own_values = {name: value for name, value in present.items() if name in own}
    live = _query(
        db,
        "SELECT sessions.id, parameters FROM sessions JOIN seats ON seats.session = sessions.id"
        f" WHERE participant=? AND task=? AND {COUNTS} AND sessions.id<>?"
        " AND json_extract(software, '$.task.version')=?",
        (participant, task.name, without, task.version),
    )

    def is_comparable(row: Row) -> bool:
        stored = read_json(row["parameters"])
        return {name: value for name, value in stored.items() if name in own} == own_values

    comparable = [row["id"] for row in live if is_comparable(row)]
    best_of = "min" if metric.better == "lower" else "max"
    rows = db.execute(
        f"SELECT level, condition, {best_of}(metric)"
        " FROM attempts JOIN sessions ON sessions.id = attempts.session"
        " JOIN seats ON seats.session = attempts.session AND seats.seat = attempts.seat AND "
        "participant=?"
        " WHERE attempts.session IN (SELECT value FROM json_each(?)) AND NOT practice AND "
        f"metric IS NOT NULL"
        " AND metric_unit=? AND COALESCE(accuracy, 1) >= COALESCE(json_extract(parameters, "
        "'$.min_accuracy'), 0)"
        " GROUP BY level, condition",
        (participant, _dump(comparable), metric.unit),
    )
    return {best_key(level, condition): value for level, condition, value in rows}


def press_times(db: sqlite3.Connection, participant: str, most: int) -> list[float]:
    """Return the last press times of a participant's switch (ms), in order, as `SwitchPressed`
    tells them. At most ``most``, of the newest sessions that count; none if a row is damaged, which
    keeps no session from beginning.
    """
    found: list[float] = []  # the newest first
    try:
        for (session,) in db.execute(_WITH_A_SWITCH, (participant, most)).fetchall():
            times = db.execute(_PRESS_TIMES, (session, SWITCH.name, most - len(found)))
            found += (time for (time,) in times)
    except sqlite3.DatabaseError:
        return []
    return found[::-1]


_WITH_A_SWITCH = (
    "SELECT sessions.id FROM seats CROSS JOIN sessions ON sessions.id=seats.session"
    f" WHERE participant=? AND {COUNTS} AND json_extract(parameters, '$.switch')='one'"
    " ORDER BY sessions.rowid DESC LIMIT ?"
)
_PRESS_TIMES = (
    "SELECT json_extract(message, '$.press_ms') FROM events WHERE session=? AND topic=?"
    " AND json_extract(message, '$.press_ms') IS NOT NULL ORDER BY seq DESC LIMIT ?"
)


def interrupt(db: sqlite3.Connection, session: str, ended: str) -> None:
    """Mark a session that was left before its end as interrupted at a time, so that it can be
    resumed.
    """
    with transaction(db) as connection:
        interrupted = (
            "UPDATE sessions SET status='interrupted', ended_at=? WHERE id=? AND status='running'"
        )
        if connection.execute(interrupted, (ended, session)).rowcount:
            log_hashes.extend(connection, session, ["ended", ended])


def _dump(value: object) -> str:
    return msgspec.json.encode(value).decode()


def _boot_id() -> str | None:
    path = Path("/proc/sys/kernel/random/boot_id")
    return path.read_text().strip() if path.exists() else None


# --- reading


def local_time(stamp: str | None, utc_offset_s: int | None = None) -> str:
    """Return a UTC stamp of the database to the minute: in local time, or at the offset of a
    session's place.
    """
    return trained_at(stamp, utc_offset_s).strftime("%Y-%m-%d %H:%M") if stamp else ""


def _query(
    db: sqlite3.Connection, sql: str, values: Sequence[object] | Mapping[str, object]
) -> Iterator[Row]:
    """Yield the rows of a query by the names of their columns."""
    found = db.execute(sql, values)
    names = [name for name, *_ in found.description]
    return (dict(zip(names, row, strict=True)) for row in found)


def _typed(table: str, row: Row, also_damaged: bool = False) -> Row:
    """Return a row with its JSON columns decoded, its boolean columns as bool, and numbers that are
    finite or None.
    """
    read: dict[Type, Callable[[Any], Any]] = {
        "json": _object_or_empty if also_damaged else read_json,
        "boolean": bool,
        "number": lambda value: value if math.isfinite(value) else None,
    }
    typed = {
        column.name: read[column.type](row[column.name])
        for column in TABLES[table].columns
        if column.type in read and row[column.name] is not None
    }
    return row | typed


@lru_cache(maxsize=256)
def _object_or_empty(text: str) -> Any:
    """Return a JSON value, the same object for the same text: most sessions share their software
    and machine.
    """
    try:
        return read_json(text)
    except StoreError:
        return {}


_COLUMNS = (
    f"SELECT sessions.*, {UTC_OFFSET} AS utc_offset_s, seats.participant, other.participant AS "
    "partner,"
    " (SELECT count(DISTINCT attempt) FROM attempts WHERE session=sessions.id AND NOT practice) "
    "AS attempts FROM "
)
_SEATS = (
    " CROSS JOIN seats ON seats.session=sessions.id AND seats.seat='A'"
    " LEFT JOIN seats AS other ON other.session=sessions.id AND other.seat='B'"
)
_LISTED = f"{_COLUMNS} sessions {_SEATS}"
"""``CROSS``: sessions are visited in their own order, so that a limit ends the search."""
_NEWEST_FIRST = " ORDER BY sessions.rowid DESC LIMIT :limit"
_LISTED_OF_ONE = (
    f"{_COLUMNS} seats AS own CROSS JOIN sessions ON sessions.id=own.session {_SEATS}"
    " WHERE own.participant=:who ORDER BY own.rowid DESC LIMIT :limit"
)
"""The seats of one participant, which are stored with their sessions, are visited from the newest
on.
"""


def listing(
    db: sqlite3.Connection,
    folder: Path,
    *,
    participant: str | None = None,
    limit: int = -1,
    also_damaged: bool = False,
) -> list[Row]:
    """Return sessions, newest first, with ``participant``, ``partner`` (or None) and their number
    of ``attempts``.

    ``utc_offset_s`` is that of the place where a session was played (see `trained_at`), None if it
    was not recorded.

    The order is that in which they were stored: the machine's clock may have been set back in
    between.

    ``participant`` selects the sessions of one participant, at any seat. The status of a session
    that is stored as running and not locked by a program is ``interrupted``. ``also_damaged``
    returns rows whose JSON is damaged as well, with an empty object in its place.
    """
    query = _LISTED_OF_ONE if participant else f"{_LISTED}{_NEWEST_FIRST}"
    rows = _query(db, query, {"who": participant, "limit": limit})
    return [_with_status(_typed("sessions", row, also_damaged), folder) for row in rows]


def latest_interrupted(db: sqlite3.Connection, folder: Path) -> Row | None:
    """Return the newest live session that can be resumed here, as `listing` does; None if there is
    none.
    """
    unfinished = f"{COUNTS} AND site='' AND status IN ('running', 'interrupted')"
    rows = _query(db, f"{_LISTED} WHERE {unfinished}{_NEWEST_FIRST}", {"limit": -1})
    interrupted = (row for row in rows if _with_status(row, folder)["status"] == "interrupted")
    row = next((row for row in interrupted if not came_by_letter(db, row["id"])), None)
    return _typed("sessions", row) if row else None


def came_by_letter(db: sqlite3.Connection, session: str) -> bool:
    """Return True if a sealed letter brought a session: another computer of this site has it, and
    goes on with it.
    """
    brought = (
        "SELECT 1 FROM letters, json_each(contents, '$.sessions') AS session WHERE "
        "direction='in' AND session.key=? LIMIT 1"
    )
    return db.execute(brought, (session,)).fetchone() is not None


def operators(db: sqlite3.Connection, session: str | None = None) -> dict[str, list[str]]:
    """Return the names of the operators, in order of arrival, by session; only sessions that had
    one.

    ``session`` selects a single session.
    """
    found: dict[str, list[str]] = {}
    of_session = " AND session_numbers.id=:session" if session else ""
    query = f"{_PRESENCE}{of_session} ORDER BY session_numbers.id, seq"
    for joined, actor in db.execute(query, {"session": session}):
        names = found.setdefault(joined, [])
        if actor not in names:
            names.append(actor)
    return found


_PRESENCE = (
    "SELECT session_numbers.id, json_extract(message, '$.actor')"
    " FROM messages INDEXED BY idx_messages_presence"
    " JOIN session_numbers ON number=session_number"
    f" WHERE topic={messages.PRESENCE_ID} AND json_extract(message, '$.role')='operator'"
)
"""The condition on the topic is a literal, as in the index, so that no other message is looked at."""


def codes(row: Row) -> tuple[str, ...]:
    """Return the codes of a listed session's participants."""
    return tuple(filter(None, (row["participant"], row["partner"])))


def participant_codes(row: Row) -> str:
    """Return the codes of a listed session's participants: "P01" or "P01, P02"."""
    return ", ".join(codes(row))


def find(db: sqlite3.Connection, folder: Path, name: str, *, also_damaged: bool = False) -> Row:
    """Find one session by its id, the beginning of its id, or ``last``; ``also_damaged`` as in
    `listing`.

    Raises:
        StoreError: there is no such session, or more than one.
    """
    if name == "last":
        found = listing(db, folder, limit=1, also_damaged=also_damaged)
    else:
        rows = _query(
            db,
            f"{_LISTED} WHERE substr(sessions.id, 1, length(:name))=:name LIMIT 2",
            {"name": name},
        )
        found = [_with_status(_typed("sessions", row, also_damaged), folder) for row in rows]
    if not name or not found:
        raise StoreError(
            f"There is no session {name or 'with an empty name'}. `sar-tui sessions` lists them.",
            bad_input=True,
        )
    if len(found) > 1:
        raise StoreError(
            f"More than one session begins with {name}. Give more of the id.", bad_input=True
        )
    return found[0]


def _with_status(row: Row, folder: Path) -> Row:
    row["status"] = status_now(row["status"], row["id"], folder)
    return row


def status_now(stored: str, session: str, folder: Path) -> str:
    """Return a session's status: interrupted if it is stored as running, and no program has locked
    it.
    """
    return (
        "interrupted" if stored == "running" and not is_held(folder, "session", session) else stored
    )


def stored_status(db: sqlite3.Connection, session: str) -> str | None:
    """Return a session's status as it is stored, locked or not; None if there is no such
    session.
    """
    row = db.execute("SELECT status FROM sessions WHERE id=?", (session,)).fetchone()
    return row[0] if row else None


def is_demonstration(db: sqlite3.Connection, schema: str = "main") -> bool:
    """Return True if a database shows what the program does, with invented people: it was made for
    that, and its first session is of one of them.
    """
    first = f"SELECT mode FROM {schema}.sessions ORDER BY rowid LIMIT 1"
    row = db.execute(first).fetchone()
    return row is not None and row[0] == "demonstration"


def rows(db: sqlite3.Connection, table: Table, session: str) -> list[Row]:
    """Return the rows of a session in one table, in order."""
    return [
        _typed(table, row)
        for row in _query(db, f"{_select(table)} WHERE session=? ORDER BY rowid", (session,))
    ]


def _select(table: str) -> str:
    return f"SELECT {', '.join(TABLES[table].names)} FROM {table}"


def stored(db: sqlite3.Connection, session: str) -> Row | None:
    """Return the row of a session as it is stored; None if there is none."""
    found = next(_query(db, f"{_select('sessions')} WHERE id=?", (session,)), None)
    return _typed("sessions", found) if found else None


def attempt_ended(row: Row) -> AttemptEnded:
    """Return the message that a row of `rows(db, "attempts", session)` was stored from, without
    choice and spreads.
    """
    return AttemptEnded(
        seat=row["seat"],
        attempt=row["attempt"],
        practice=row["practice"],
        level=row["level"],
        metric=row["metric"],
        metric_unit=row["metric_unit"],
        accuracy=row["accuracy"],
        correct=row["correct"],
        trials=row["trials"],
        goal=row["goal"],
        outcome=row["outcome"],
        feedback=row["feedback"],
        qualities=row["qualities"],
        started=row["started_ns"],
        ended=row["ended_ns"],
        condition=row["condition"],
    )


def history(db: sqlite3.Connection, session: str) -> Iterator[Record]:
    """Yield the messages of a session, sensor samples included, in the order of a replay.

    Raises:
        StoreError: this version of the program cannot read a message, or samples are damaged.
    """
    stored = messages.read(db, session)
    records = (Record(one.seq, one.at, one.topic, one.message) for one in stored)
    return merge(imu.blocks(db, session), records, key=lambda record: record.seq)

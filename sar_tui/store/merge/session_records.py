"""Records of sessions: copies those that are new or longer, and decides between those that
contradict each other.
"""

import sqlite3
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

from sar_tui.store.merge import conflicts
from sar_tui.store.merge.comparison import CHANGED_LATER, LOG, compare
from sar_tui.store.merge.conflicts import Content
from sar_tui.store.merge.people import People, in_full
from sar_tui.store.record_changes import changes
from sar_tui.store.tables import SESSION_TABLES, TABLES

_AT_ONCE = 20
"""Sessions that are compared or copied by one statement."""
_RANKS = ("running", "interrupted", "dismissed", "aborted", "completed", "refused", "discarded")
"""The status of a session whose record is the same in both databases: the later one of these is
kept.
"""
_RANK = (
    "CASE {schema}.status "
    + " ".join(f"WHEN '{name}' THEN {rank}" for rank, name in enumerate(_RANKS))
    + " END"
)


class Changed(NamedTuple):
    """Sessions that the main database did not have, and those whose record became longer or
    another.
    """

    added: list[str]
    updated: list[str]


def merge_sessions(
    db: sqlite3.Connection, people: People, progress: Callable[[int, int], None]
) -> Changed:
    """Bring the sessions of ``other`` into the main database."""
    there = [id for (id,) in db.execute("SELECT id FROM other.sessions ORDER BY started_at, id")]
    here = {id for (id,) in db.execute("SELECT id FROM main.sessions")}
    contradicted = {
        key
        for schema in ("main", "other")
        for (key,) in db.execute(f"SELECT key FROM {schema}.conflicts WHERE kind='session'")
    }
    result = Changed([], [])
    for done in range(0, len(there), _AT_ONCE):
        some = there[done : done + _AT_ONCE]
        new = [id for id in some if id not in here]
        relations = compare(db, [id for id in some if id in here])
        longer = [
            id
            for id, relation in relations.items()
            if relation == "longer there" and id not in contradicted
        ]
        remove(db, longer)
        _copy(db, [*new, *longer])
        equal = [
            id
            for id, relation in relations.items()
            if relation == "equal" and id not in contradicted
        ]
        result.added.extend(new)
        result.updated.extend([*longer, *_keep_later_status(db, equal)])
        for id, relation in relations.items():
            if id in contradicted or relation == "contradictory":
                result.updated.extend([id] * _decide(db, people, id))
        progress(done + len(some), len(there))
    db.execute(
        "INSERT OR IGNORE INTO main.conflicts SELECT * FROM other.conflicts WHERE kind='session' "
        "AND key NOT IN"
        " (SELECT value FROM json_each(?))",
        (_json(here),),
    )
    return result


def follow_moves(db: sqlite3.Connection, people: People) -> None:
    """Give the records of sessions that were moved to another participant that participant, in both
    databases.
    """
    sat = (
        "SELECT 1 FROM main.seats WHERE seats.session=there.session"
        " AND seats.participant=there.participant"
    )
    others = " UNION ".join(
        f"SELECT session FROM {schema}.records AS there WHERE session NOTNULL AND NOT EXISTS ({sat})"
        for schema in ("main", "other")
    )
    moved = db.execute(
        f"SELECT id, site FROM main.sessions WHERE id IN ({others}) ORDER BY id"
    ).fetchall()
    for session, site in moved:
        for change in changes(db, session):
            if change.change == "moved" and change.details:
                before, after = (
                    people.stored(in_full(str(change.details[name]), site or people.own))
                    for name in ("before", "after")
                )
                for schema in ("main", "other"):
                    db.execute(
                        f"UPDATE {schema}.records SET participant=? WHERE session=? AND "
                        "participant=?",
                        (after, session, before),
                    )


def _json(ids: set[str]) -> str:
    import msgspec

    return msgspec.json.encode(sorted(ids)).decode()


def remove(db: sqlite3.Connection, sessions: Sequence[str]) -> None:
    """Remove sessions from the main database, to put longer records in their place."""
    for session in sessions:
        for table in SESSION_TABLES:
            db.execute(f"DELETE FROM main.{table} WHERE session=?", (session,))
        number = "(SELECT number FROM main.session_numbers WHERE id=?)"
        db.execute(f"DELETE FROM main.messages WHERE session_number={number}", (session,))
        db.execute("DELETE FROM main.sessions WHERE id=?", (session,))


def _copy(db: sqlite3.Connection, sessions: Sequence[str]) -> None:
    """Copy sessions that the main database does not have."""
    if not sessions:
        return
    db.execute("CREATE TEMP TABLE IF NOT EXISTS wanted (number INTEGER PRIMARY KEY, id TEXT)")
    db.execute("DELETE FROM temp.wanted")
    db.executemany("INSERT INTO temp.wanted (id) VALUES (?)", [(session,) for session in sessions])
    for table in ("sessions", *SESSION_TABLES):
        listed = ", ".join(f'"{name}"' for name in TABLES[table].names)
        rows = ", ".join(f'there."{name}"' for name in TABLES[table].names)
        own = "id" if table == "sessions" else "session"
        db.execute(
            f"INSERT INTO main.{table} ({listed}) SELECT {rows} FROM temp.wanted CROSS JOIN "
            f"other.{table} AS there"
            f" ON there.{own}=wanted.id ORDER BY wanted.number, there.rowid"
        )
    db.execute(
        "INSERT OR IGNORE INTO main.session_numbers (id) SELECT id FROM temp.wanted ORDER BY number"
    )
    db.execute(
        "INSERT INTO main.messages (session_number, seq, run, at_ns, topic, message)"
        " SELECT here.number, there.seq, there.run, there.at_ns, topic_numbers.here, "
        "there.message FROM temp.wanted"
        " CROSS JOIN main.session_numbers AS here ON here.id=wanted.id"
        " CROSS JOIN other.session_numbers AS numbers ON numbers.id=wanted.id"
        " CROSS JOIN other.messages AS there ON there.session_number=numbers.number"
        " JOIN temp.topic_numbers ON topic_numbers.there=there.topic ORDER BY here.number, "
        "there.seq"
    )


def _keep_later_status(db: sqlite3.Connection, sessions: Sequence[str]) -> Iterator[str]:
    """Give sessions whose records are equal the later status of both, and yield those that were
    changed.
    """
    later = (
        "SELECT there.status, there.ended_at FROM other.sessions AS there JOIN main.sessions AS "
        "here USING (id)"
        f" WHERE there.id=? AND ({_RANK.format(schema='there')}, coalesce(there.ended_at, ''))"
        f" > ({_RANK.format(schema='here')}, coalesce(here.ended_at, ''))"
    )
    for session in sessions:
        if found := db.execute(later, (session,)).fetchone():
            db.execute(
                "UPDATE main.sessions SET status=?, ended_at=? WHERE id=?", (*found, session)
            )
            yield session


# --- records that contradict each other


def _decide(db: sqlite3.Connection, people: People, session: str) -> bool:
    """Let one version of a session be in the tables, and keep the others aside; return True if it
    is another one.
    """
    here, there = (
        conflicts.in_words(_content(db, schema, session), people) for schema in ("main", "other")
    )
    known = conflicts.contents(db, "main", "session", session)
    chosen, *others = _versions(
        [here, there, *known, *conflicts.contents(db, "other", "session", session)]
    )
    for version in known:
        conflicts.drop(db, "session", session, conflicts.digest(version))
    for version in others:
        conflicts.keep(db, "main", "session", session, version)
    if conflicts.digest(chosen) == conflicts.digest(here):
        return False
    remove(db, [session])
    _store(db, session, conflicts.as_stored(chosen, people))
    return True


def _content(db: sqlite3.Connection, schema: str, session: str) -> Content:
    """Return all rows of a session."""
    found: Content = {}
    for table in ("sessions", *SESSION_TABLES):
        own = "id" if table == "sessions" else "session"
        found[table] = _rows(
            db,
            f"SELECT {_listed(db, table)} FROM {schema}.{table} WHERE {own}=? ORDER BY rowid",
            session,
        )
    found["messages"] = _rows(
        db,
        f"SELECT seq, run, at_ns, name, fields, message FROM {schema}.messages JOIN "
        f"{schema}.topics ON topics.id=topic"
        f" WHERE session_number=(SELECT number FROM {schema}.session_numbers WHERE id=?)"
        " ORDER BY seq",
        session,
    )
    return found


def _listed(db: sqlite3.Connection, table: str) -> str:
    return ", ".join(f'"{name}"' for name in TABLES[table].names)


def _rows(db: sqlite3.Connection, query: str, session: str) -> list[dict[str, Any]]:
    found = db.execute(query, (session,))
    names = [name for name, *_ in found.description]
    return [dict(zip(names, row, strict=True)) for row in found]


def _versions(contents: Sequence[Content]) -> list[Content]:
    """Return the versions of a session that no other one extends, the one to be in the tables
    first.
    """
    kept: list[Content] = []
    for content in contents:
        if any(_extends(other, content) for other in kept):
            continue
        kept = [other for other in kept if not _extends(content, other)]
        equal = [other for other in kept if _is_equal(other, content)]
        kept = [other for other in kept if other not in equal]
        kept.append(max(content, *equal, key=_status) if equal else content)
    return sorted(kept, key=lambda one: (-len(_log(one)), conflicts.digest(one)))


def _extends(longer: Content, shorter: Content) -> bool:
    return _facts(longer) == _facts(shorter) and _log(longer) > _log(shorter)


def _facts(content: Content) -> dict[str, Any]:
    (row,) = content["sessions"]
    return {name: value for name, value in row.items() if name not in CHANGED_LATER}


def _status(content: Content) -> tuple[int, str]:
    (row,) = content["sessions"]
    return _RANKS.index(row["status"]) if row["status"] in _RANKS else -1, row["ended_at"] or ""


def _is_equal(content: Content, other: Content) -> bool:
    """Return True if two versions differ in nothing, or only in what became of the session
    afterwards.
    """
    return _without_status(content) == _without_status(other)


def _without_status(content: Content) -> str:
    return conflicts.digest({**content, "sessions": [_facts(content)]})


def _log(content: Content) -> frozenset[tuple[object, ...]]:
    """Return the rows of the log of a version."""
    left_out = {**LOG, "messages": ()}
    return frozenset(
        (
            table,
            *((name, value) for name, value in sorted(row.items()) if name not in left_out[table]),
        )
        for table in left_out
        for row in content[table]
    )


def _store(db: sqlite3.Connection, session: str, content: Content) -> None:
    """Store the rows of a session that was removed, or is new."""
    for table, rows in content.items():
        if table != "messages":
            for row in rows:
                listed, slots = ", ".join(f'"{name}"' for name in row), ", ".join("?" for _ in row)
                db.execute(
                    f"INSERT INTO main.{table} ({listed}) VALUES ({slots})", list(row.values())
                )
    db.execute("INSERT OR IGNORE INTO main.session_numbers (id) VALUES (?)", (session,))
    for row in content["messages"]:
        db.execute(
            "INSERT OR IGNORE INTO main.topics (name, fields) VALUES (?,?)",
            (row["name"], row["fields"]),
        )
        db.execute(
            "INSERT INTO main.messages SELECT number, ?, ?, ?, topics.id, ? FROM "
            "main.session_numbers, main.topics"
            " WHERE session_numbers.id=? AND name=? AND fields=?",
            (
                row["seq"],
                row["run"],
                row["at_ns"],
                row["message"],
                session,
                row["name"],
                row["fields"],
            ),
        )

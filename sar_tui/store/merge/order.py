"""The order of sessions: the database's own as they were stored, those of other sites between them
by time.
"""

import sqlite3


def put_in_order(db: sqlite3.Connection) -> None:
    """Renumber the rows of sessions and seats, so that lists and reports have the sessions in their
    order.

    A session of this site that seems to have begun before an earlier one, as the clock was set
    back, stays after it.
    """
    stored = db.execute("SELECT id, site, started_at FROM main.sessions ORDER BY rowid").fetchall()
    latest, began = "", {}
    for id, site, started_at in stored:
        if not site:
            latest = max(latest, started_at)
        began[id] = started_at if site else latest
    place = {id: number for number, (id, *_) in enumerate(stored)}
    is_own = {id: not site for id, site, _ in stored}
    wanted = sorted(
        began, key=lambda id: (began[id], *((0, place[id], "") if is_own[id] else (1, 0, id)))
    )
    first = next(
        (
            number
            for number, (id, (old, *_)) in enumerate(zip(wanted, stored, strict=True))
            if id != old
        ),
        None,
    )
    if first is not None:
        _move_to_end(db, wanted[first:])


def _move_to_end(db: sqlite3.Connection, sessions: list[str]) -> None:
    (last,) = db.execute("SELECT max(rowid) FROM main.sessions").fetchone()
    db.executemany(
        "UPDATE main.sessions SET rowid=? WHERE id=?",
        [(last + n, id) for n, id in enumerate(sessions, start=1)],
    )
    (seat,) = db.execute("SELECT max(rowid) FROM main.seats").fetchone()
    for id in sessions:
        for (old,) in db.execute(
            "SELECT rowid FROM main.seats WHERE session=? ORDER BY seat", (id,)
        ).fetchall():
            seat += 1
            db.execute("UPDATE main.seats SET rowid=? WHERE rowid=?", (seat, old))

"""Authors of what another site's database holds: this site's own records are never changed from
there.

Only a site writes its records, and those of its participants. What another database names as this
site's is compared with what this database has; what is not the same, and what another site says of
people who are not its own, is taken out of the copy and told.
"""

import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from sar_tui.store.merge import conflicts
from sar_tui.store.merge.comparison import compare
from sar_tui.store.merge.people import Pair, People, in_full, site_of
from sar_tui.store.tables import SESSION_TABLES, TABLES, with_column


class _Records(NamedTuple):
    """A table with an author in each row. ``words``: SQL of the name of a row, for people."""

    table: str
    words: str
    may_lack: str = ""


_RECORDS = (
    _Records(
        "programmes",
        "'version ' || version || ' of the programme of ' || participant || ' for ' || task",
    ),
    _Records(
        "records",
        "'version ' || version || ' of the record ' || id || ' (' || kind || ')'",
        may_lack="session",
    ),
    _Records("studies", "'version ' || version || ' of the study ' || name"),
    _Records("exports", "'export of ' || exported_at"),
    _Records("people_events", "'event ' || id || ' (' || event || ') of ' || participant"),
)
_OTHERWISE = "The {what} is {own}'s by what {site} has, and is not so here. It is left out."
_ANOTHERS = "The {what} is {author}'s by what {site} has, but {code} is of {home}. It is left out."
_NOT_THERE = (
    "The {what} is of session {id} by what {site} has, and {code} was not in it. It is left out."
)
_PAIR = (
    "{site} says that {first} and {second} are one person. If they are: sar-tui merge --same "
    "{first}={second}"
)


def split_pairs(people: People, pairs: Iterable[Pair], site: str) -> tuple[set[Pair], list[str]]:
    """Return the pairs of another site that are not about this site's own people, and sentences on
    the others.
    """
    accepted = set(pairs)
    everybody = People(people.own, people.same | accepted)

    def touches_own(pair: Pair) -> bool:
        return any(site_of(code) == people.own for code in everybody.group(pair[0]))

    refused = sorted(pair for pair in accepted - people.same if touches_own(pair))
    sentences = [_PAIR.format(site=site, first=first, second=second) for first, second in refused]
    return accepted - set(refused), sentences


def refuse(
    db: sqlite3.Connection, people: People, site: str, *, has_other_names: bool
) -> list[str]:
    """Take out of ``other`` what only another site could have written, and return a sentence on
    each.

    What is this site's own and the same here is taken out, too: there is nothing to do with it.

    Args:
        site: of the other database, whose rows have the names of this one already.
        has_other_names: people of this site have names there by which they are not known here, so
            that records which this database has are not compared.
    """
    own = people.own
    found = [*_sessions(db, people, site, has_other_names), *_participants(db, people, site)]
    for records in _RECORDS:
        found += _records(db, people, site, records, has_other_names)
    found += [_OTHERWISE.format(what=what, own=own, site=site) for what in _versions(db, own)]
    return found


def leave_out(db: sqlite3.Connection, sessions: Iterable[str]) -> None:
    """Remove sessions from the copy of the other database, with all that belongs to them."""
    for id in sessions:
        db.execute("DELETE FROM other.sessions WHERE id=?", (id,))
        db.execute("DELETE FROM other.conflicts WHERE kind='session' AND key=?", (id,))
        for table in with_column("session"):
            db.execute(f"DELETE FROM other.{table} WHERE session=?", (id,))


def _sessions(
    db: sqlite3.Connection, people: People, site: str, has_other_names: bool
) -> Iterator[str]:
    here = {id for (id,) in db.execute("SELECT id FROM main.sessions WHERE site=''")}
    owned = {id for (id,) in db.execute("SELECT id FROM other.sessions WHERE site=''")}
    # One that is this site's own by its id is so, whatever the other database calls its author.
    owned |= {id for (id,) in db.execute("SELECT id FROM other.sessions")} & here
    relations = {} if has_other_names else compare(db, sorted(owned & here))
    for id in sorted(owned):
        if id not in here or relations.get(id) in ("longer there", "contradictory"):
            yield _OTHERWISE.format(what=f"session {id}", own=people.own, site=site)
    _leave_out_session_only(db, sorted(owned))
    strangers = []
    for id, author, code in db.execute(
        "SELECT id, site, participant FROM other.sessions JOIN other.seats ON session=id ORDER BY "
        "id, seat"
    ).fetchall():
        if home := _home(people, code, author):
            strangers.append(id)
            yield _ANOTHERS.format(
                what=f"session {id}", author=author, site=site, home=home, code=code
            )
    leave_out(db, strangers)


def _leave_out_session_only(db: sqlite3.Connection, sessions: Sequence[str]) -> None:
    """Remove sessions whose records of people are looked at by themselves."""
    for id in sessions:
        db.execute("DELETE FROM other.sessions WHERE id=?", (id,))
        for table in SESSION_TABLES:
            db.execute(f"DELETE FROM other.{table} WHERE session=?", (id,))


def _home(people: People, code: str, author: str) -> str:
    """Return the site whose participant has a code, if the author of a record is another; else an
    empty text.
    """
    full = in_full(code, people.own)
    return "" if author in map(site_of, people.group(full)) else site_of(full)


def _participants(db: sqlite3.Connection, people: People, site: str) -> Iterator[str]:
    """Take out this site's own participants: nobody else adds them, or changes since when they are
    known.
    """
    here = {code for (code,) in db.execute("SELECT code FROM main.participants")}
    for (code,) in db.execute(
        "SELECT code FROM other.participants WHERE code NOT LIKE '%@%' ORDER BY code"
    ).fetchall():
        if len(people.group(in_full(code, people.own))) > 1:
            continue  # a person of the other site has this code here
        if code not in here:
            yield _OTHERWISE.format(what=f"participant {code}", own=people.own, site=site)
        db.execute("DELETE FROM other.participants WHERE code=?", (code,))


def _records(
    db: sqlite3.Connection, people: People, site: str, records: _Records, has_other_names: bool
) -> Iterator[str]:
    names = [
        name
        for name in TABLES[records.table].names
        if (records.table, name) != ("exports", "number")
    ]
    same = " AND ".join(_same(records, name) for name in names)
    condition = (
        ""
        if has_other_names
        else f" AND NOT EXISTS (SELECT 1 FROM main.{records.table} AS here WHERE {same})"
    )
    for (what,) in db.execute(
        f"SELECT {records.words} FROM other.{records.table} AS there WHERE site=''{condition} "
        "ORDER BY rowid"
    ).fetchall():
        yield _OTHERWISE.format(what=what, own=people.own, site=site)
    db.execute(f"DELETE FROM other.{records.table} WHERE site=''")
    if "participant" in names:
        # A programme keeps the code that its site gave, and so does what was done for a person.
        keeps = records.table in ("programmes", "people_events")
        known = People(people.own, ()) if keeps else people
        for row, what, author, code in db.execute(
            f"SELECT rowid, {records.words}, site, participant FROM other.{records.table} ORDER "
            "BY rowid"
        ).fetchall():
            if home := _home(known, code, author):
                db.execute(f"DELETE FROM other.{records.table} WHERE rowid=?", (row,))
                yield _ANOTHERS.format(what=what, author=author, site=site, home=home, code=code)
    if "session" in names:
        yield from _of_strangers(db, site, records)


def _of_strangers(db: sqlite3.Connection, site: str, records: _Records) -> Iterator[str]:
    """Take out records of people who did not sit in the session that they name: they would be read
    as another's.
    """
    sat = (
        "SELECT 1 FROM {}.seats WHERE seats.session=there.session AND "
        "seats.participant=there.participant"
    )
    for row, what, id, code in db.execute(
        f"SELECT rowid, {records.words}, session, participant FROM other.{records.table} AS there "
        "WHERE session IS NOT"
        f" NULL AND NOT EXISTS ({sat.format('main')}) AND NOT EXISTS ({sat.format('other')}) "
        "ORDER BY rowid"
    ).fetchall():
        db.execute(f"DELETE FROM other.{records.table} WHERE rowid=?", (row,))
        yield _NOT_THERE.format(what=what, id=id, site=site, code=code)


def _same(records: _Records, name: str) -> str:
    condition = f"here.{name} IS there.{name}"
    return f"({condition} OR there.{name} IS NULL)" if name == records.may_lack else condition


def _versions(db: sqlite3.Connection, own: str) -> Iterator[str]:
    """Take out versions of this site's own records that are kept aside there; yield those that are
    not known here.
    """
    for kind, key, digest, packed in db.execute(
        "SELECT kind, key, digest, content FROM other.conflicts"
    ).fetchall():
        content = conflicts.decoded(packed)
        (row,) = content["sessions"] if kind == "session" else next(iter(content.values()))
        if row["site"] != own:
            continue
        db.execute(
            "DELETE FROM other.conflicts WHERE kind=? AND key=? AND digest=?", (kind, key, digest)
        )
        known = "SELECT 1 FROM main.conflicts WHERE kind=? AND key=? AND digest=?"
        if not db.execute(known, (kind, key, digest)).fetchone():
            yield f"other version of the {kind} {key}"

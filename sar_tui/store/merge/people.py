"""Participants of several sites: which codes are the same person, and the code by which a database
stores each.

A code in full names its site: P01@BERN. The database of a site stores its own codes without the
site.
"""

import re
import sqlite3
from collections.abc import Callable, Iterable

from sar_tui.store.database import StoreError
from sar_tui.store.participants import check_code
from sar_tui.store.sites import OF_SITES

Pair = tuple[str, str]
"""Two codes in full of the same person: the second is the one to be used."""


class People:
    """The participants that a database of the site ``own`` knows, where ``same`` are the same
    persons.
    """

    def __init__(self, own: str, same: Iterable[Pair]) -> None:
        self.own = own
        self.same = frozenset(same)
        self._replaced = {code for code, _ in self.same}
        self._groups: dict[str, set[str]] = {}
        for pair in sorted(self.same):
            group = set().union(*(self._groups.get(code, {code}) for code in pair))
            self._groups |= dict.fromkeys(group, group)

    def group(self, code: str) -> set[str]:
        """Return all codes in full of the person who has a code in full."""
        return self._groups.get(code, {code})

    def check(self) -> None:
        """Raise StoreError if two codes of one site would be the same person."""
        for group in self._groups.values():
            sites = [site_of(code) for code in group]
            if len(set(sites)) < len(sites):
                doubled = sorted(code for code in group if sites.count(site_of(code)) > 1)
                raise StoreError(
                    f"{' and '.join(doubled)} would be the same person: a person has one code at "
                    "a site.",
                    bad_input=True,
                )

    def stored(self, code: str) -> str:
        """Return the code by which this database stores the person who has a code in full.

        It is this site's own if there is one; else one that no other was said to be replaced by.
        """
        group = self.group(code)
        chosen = min(
            group,
            key=lambda one: (site_of(one) != self.own, one in self._replaced, site_of(one), one),
        )
        return self.shortened(chosen)

    def shortened(self, code: str) -> str:
        """Return a code in full without the site if it is this database's own."""
        return code.removesuffix(f"@{self.own}") if self.own else code

    def name(self, code: str) -> str:
        """Return the code in full that stands for a person in every database: the first one of
        all.
        """
        return min(self.group(code))


def in_full(code: str, site: str) -> str:
    """Return a code as it is stored at a site with its site."""
    return code if "@" in code or not site else f"{code}@{site}"


def site_of(code: str) -> str:
    """Return the site that a code names; empty if it names none."""
    return code.partition("@")[2]


def local_code(code: str) -> str:
    """Return a code as its own site stores it."""
    return code.partition("@")[0]


def parse_same(text: str, own: str) -> Pair:
    """Return the codes in full of "P01@BERN=P01". Raises StoreError."""
    parts = [part.strip() for part in text.split("=")]
    if len(parts) != 2 or not re.search(r"\w", parts[0]):
        raise StoreError(
            f"--same takes two codes, such as P01@BERN=P01, not {text!r}.", bad_input=True
        )
    first, second = (in_full(check_code(part), own) for part in parts)
    if site_of(first) == site_of(second):
        raise StoreError(
            f"{first} and {second} are of one site: --same is for the codes of one person at two "
            "sites.",
            bad_input=True,
        )
    return first, second


def stored_pairs(db: sqlite3.Connection, schema: str = "main") -> set[Pair]:
    """Return the pairs of codes that a database has as the same person."""
    return set(db.execute(f"SELECT code, same_as FROM {schema}.same_people").fetchall())


def code_at(db: sqlite3.Connection, code: str, site: str) -> str:
    """Return the code as it is stored of a person at the site of a row: for P01, P07@BERN if that
    is the same one.
    """
    if not site:
        return code
    own = db.execute("SELECT code FROM site").fetchone()
    people = People(own[0] if own else "", stored_pairs(db))
    return next(
        (one for one in people.group(in_full(code, people.own)) if site_of(one) == site), code
    )


def other_code(db: sqlite3.Connection, code: str) -> str:
    """Return the code by which this database stores a person who has another code, too; empty if it
    is this one.
    """
    own = db.execute("SELECT code FROM site").fetchone()
    people = People(own[0] if own else "", stored_pairs(db))
    stored = people.stored(in_full(code, people.own))
    return "" if stored == people.shortened(in_full(code, people.own)) else stored


# --- renaming


_PERSONS = (
    ("seats", "participant"),
    ("records", "participant"),
)
"""Columns with the code of a person, beside ``participants``. Programmes keep the code that their
site gave.
"""
_MARK = "\x01"
"""Put before a value that is to be replaced: no value begins with it."""


def rename_others(db: sqlite3.Connection, people: People, site: str) -> None:
    """Rename all in the attached database ``other``, of a site, to what the main database
    stores.
    """
    _rename(db, "other", lambda code: people.stored(in_full(code, site)))
    _replace(
        db, "other", "programmes", "participant", lambda code: people.shortened(in_full(code, site))
    )
    for column in ("participant", "replaced_by"):
        _replace(
            db,
            "other",
            "people_events",
            column,
            lambda code: code and people.shortened(in_full(code, site)),
        )
    if site != people.own:  # ids of records are short, so that two sites may have the same
        _replace(
            db,
            "other",
            "records",
            "id",
            lambda id: people.shortened(in_full(id, site)),
        )
        for table in OF_SITES:
            db.execute(f"UPDATE other.{table} SET site=CASE site WHEN '' THEN ? WHEN ? THEN '' ELSE site END",
                       (site, people.own))  # fmt: skip


def rename_own(db: sqlite3.Connection, people: People) -> int:
    """Rename those in the main database who are known as the same person now, and return the number
    of changed rows.
    """
    return _rename(db, "main", lambda code: people.stored(in_full(code, people.own)))


def _rename(db: sqlite3.Connection, schema: str, stored: Callable[[str], str]) -> int:
    changed = sum(_replace(db, schema, table, column, stored) for table, column in _PERSONS)
    rows = db.execute(
        f"SELECT code, created_at FROM {schema}.participants ORDER BY rowid"
    ).fetchall()
    renamed = [row for row in rows if stored(row[0]) != row[0]]
    db.executemany(
        f"DELETE FROM {schema}.participants WHERE code=?", [(code,) for code, _ in renamed]
    )
    for code, created_at in renamed:
        add_participant(db, schema, stored(code), created_at)
    return changed + len(renamed)


def add_participant(db: sqlite3.Connection, schema: str, code: str, created_at: str) -> int:
    """Add a participant, or let one who is known be as old as is known now; return the number of
    changed rows.
    """
    return db.execute(
        f"INSERT INTO {schema}.participants (code, created_at, site) VALUES (?,?,?) ON CONFLICT "
        "(code) DO UPDATE"
        " SET created_at=excluded.created_at WHERE excluded.created_at<created_at",
        (code, created_at, site_of(code)),
    ).rowcount


def _replace(
    db: sqlite3.Connection, schema: str, table: str, column: str, stored: Callable[[str], str]
) -> int:
    """Replace the values of a column all at once: a new value may be the old one of another row."""
    olds = [old for (old,) in db.execute(f"SELECT DISTINCT {column} FROM {schema}.{table}")]
    news = [(old, new) for old in olds if (new := stored(old)) != old]
    marked = [(f"{_MARK}{old}", old) for old, _ in news]
    db.executemany(f"UPDATE {schema}.{table} SET {column}=? WHERE {column}=?", marked)
    statement = f"UPDATE OR IGNORE {schema}.{table} SET {column}=? WHERE {column}=?"
    changed = sum(db.execute(statement, (new, f"{_MARK}{old}")).rowcount for old, new in news)
    # Of two rows that would have the same key now, one keeps what it had.
    db.executemany(
        f"UPDATE {schema}.{table} SET {column}=? WHERE {column}=?",
        [(old, mark) for mark, old in marked],
    )
    return changed

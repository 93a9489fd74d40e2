"""Rules for the codes, names and texts of a database from elsewhere: those that typed ones pass,
too.

An id becomes the name of a file, a code and a name stand in lists and are typed again, and a text
is drawn.
"""

import re
import sqlite3
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, get_args

import msgspec

from sar_tui.model.visible_text import visible
from sar_tui.records.kind import LONGEST_TEXT as LONGEST_REMARK
from sar_tui.store.database import StoreError
from sar_tui.store.merge import conflicts
from sar_tui.store.merge.conflicts import Content
from sar_tui.store.participants import check_code
from sar_tui.store.people_events import What
from sar_tui.store.programmes import LONGEST_TEXT
from sar_tui.store.sites import check_site
from sar_tui.store.tables import SESSION_TABLES, TABLES, Form
from sar_tui.store.texts import check_text

Rule = Callable[[Any], bool]
"""A function that returns True if a value, which is not missing, is allowed."""

_SHOWN = 40
"""Characters of a value that is refused, in the message."""
_NUMBERS = (int, float)
_BY_TYPE: Mapping[str, tuple[type, ...]] = {"TEXT": (str,), "INTEGER": _NUMBERS, "FLOAT": _NUMBERS, "REAL": _NUMBERS,
                                            "BLOB": (bytes, str)}  # fmt: skip
_TYPE_NAMES = {int: "integer", float: "real", str: "text", bytes: "blob"}


def _text(longest: int) -> Rule:
    def checked(value: str) -> str:
        check_text("The text", value, longest)
        return value  # some texts keep the blanks at their ends

    return _checked(checked)


def _form(pattern: str) -> Rule:
    compiled = re.compile(pattern)
    return lambda value: compiled.fullmatch(value) is not None


def _are_values(content: str) -> bool:
    """Return True if a text is the values of a record: numbers and texts by the names of fields."""
    try:
        values = msgspec.json.decode(content, type=dict[str, int | float | str | bool])
    except (msgspec.MsgspecError, UnicodeEncodeError):
        return False
    texts = [*values, *(value for value in values.values() if isinstance(value, str))]
    return all(map(_text(LONGEST_REMARK), texts))


def _checked(check: Callable[[str], str]) -> Rule:
    """Return the rule that a value is as a check of what is typed returns it."""

    def is_stored_form(value: str) -> bool:
        try:
            return check(value) == value
        except StoreError:
            return False

    return is_stored_form


_FORMS: dict[Form, Rule] = {
    "code": _checked(check_code),
    "date": _form(r"[0-9T:.+Z -]{0,40}"),
    "record": _form(r"[A-Za-z0-9][A-Za-z0-9_-]{0,95}(@[A-Z0-9][A-Z0-9-]{0,15})?"),
    "kind": _form(r"[A-Za-z0-9][A-Za-z0-9 ._-]{0,63}"),
    "event": _form("|".join(get_args(What))),
    "id": _form(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}"),
    "line": _text(1000),
    "note": _text(4000),
    "reason": _text(LONGEST_TEXT),
    "remark": _text(LONGEST_REMARK),
    "replacement": lambda code: not code or _checked(check_code)(code),
    "seat": _form("[AB]"),
    "site": _checked(check_site),
    "task": _form(r"(?:[^\W\d]\w{0,63})?"),
    "theme": _form(r"(?:\w[\w .-]{0,63})?"),
    "topic": _form(r"[\w./-]{1,100}"),
    "values": _are_values,
    "word": _form(r"[a-z]{0,32}"),
}
_OPTIONAL_SITE: Rule = lambda value: not value or _FORMS["site"](value)  # noqa: E731


def check_foreign(db: sqlite3.Connection, path: Path) -> None:
    """Check a copy of another database.

    Args:
        path: of the other database, for messages.

    Raises:
        StoreError: a value breaks a rule.
    """
    for table in _tables(db):
        rules = _rules(table)
        for name, types in _types(db, table).items():
            allowed = ", ".join(f"'{_TYPE_NAMES[kind]}'" for kind in types)
            wrong = (
                f'SELECT "{name}" FROM "{table}" WHERE typeof("{name}") NOT IN (\'null\', '
                f"{allowed}) LIMIT 1"
            )
            for (value,) in db.execute(wrong):
                raise _refused(path, table, name, value)
        for name, rule in rules.items():
            for (value,) in db.execute(f'SELECT DISTINCT "{name}" FROM "{table}"'):
                if value is not None and not rule(value):
                    raise _refused(path, table, name, value)
    for kind, key, digest, packed in db.execute("SELECT kind, key, digest, content FROM conflicts"):
        if not _is_version(db, kind, key, digest, packed):
            raise _refused(path, "conflicts", "content", key)


def _tables(db: sqlite3.Connection) -> list[str]:
    found = db.execute("SELECT name FROM sqlite_master WHERE type='table'").fetchall()
    return [name for (name,) in found if not name.startswith(("_", "sqlite_"))]


def _rules(table: str) -> dict[str, Rule]:
    """Return the rules of a table's texts; of its own tables alone does a merge know any."""
    if table not in TABLES:
        return {}
    found = {
        column.name: _FORMS[column.form]
        for column in TABLES[table].columns
        if (column.type in ("string", "datetime") or column.form == "values")
        and column.form in _FORMS
    }
    return found | {"site": _OPTIONAL_SITE} if "site" in found else found


def _types(db: sqlite3.Connection, table: str) -> dict[str, tuple[type, ...]]:
    """Return the types of the columns that declare one."""
    declared = db.execute(f'PRAGMA table_info("{table}")').fetchall()
    return {
        name: _BY_TYPE[kind.upper()] for _, name, kind, *_ in declared if kind.upper() in _BY_TYPE
    }


def _refused(path: Path, table: str, column: str, value: object) -> StoreError:
    shown = visible(str(value))
    shown = f"{shown[:_SHOWN]}…" if len(shown) > _SHOWN else shown
    return StoreError(
        f"{path} cannot be merged: {table}.{column} is “{shown}” somewhere, which this program "
        "does not store.",
        bad_input=True,
    )


def _is_version(db: sqlite3.Connection, kind: str, key: str, digest: str, packed: bytes) -> bool:
    """Return True if a version of a record that is kept aside is one, and passes the same rules."""
    try:
        content = conflicts.decoded(packed)
    except ValueError:
        return False
    if conflicts.digest(content) != digest or not all(
        _passes(db, *each) for each in _each_row(content)
    ):
        return False
    if kind != "session":
        return conflicts.is_record(kind, content) and conflicts.key_of(kind, content) == key
    known = {"sessions", "messages", *SESSION_TABLES}
    rows = [
        row
        for table, rows in content.items()
        if table not in ("sessions", "messages")
        for row in rows
    ]
    ids = {row["id"] for row in content.get("sessions", ())} | {row["session"] for row in rows}
    return known == content.keys() and len(content["sessions"]) == 1 and ids == {key}


def _each_row(content: Content) -> Iterator[tuple[str, dict[str, Any]]]:
    return ((table, row) for table, rows in content.items() for row in rows)


_MESSAGE = {"seq", "run", "at_ns", "name", "fields", "message"}


def _passes(db: sqlite3.Connection, table: str, row: dict[str, Any]) -> bool:
    if table == "messages":
        is_named = (
            row.keys() == _MESSAGE and isinstance(row["name"], str) and _FORMS["topic"](row["name"])
        )
        return is_named and all(isinstance(row[name], int) for name in ("seq", "run", "at_ns"))
    if table not in _tables(db):
        return False
    types, rules = _types(db, table), _rules(table)
    if row.keys() - TABLES[table].names or set(TABLES[table].key) - row.keys():
        return False
    return all(
        value is None
        or (
            isinstance(value, types.get(name, (int, float, str, bytes)))
            and (name not in rules or rules[name](value))
        )
        for name, value in row.items()
    )

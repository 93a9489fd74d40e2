"""Columns out of a JSON column whose keys differ between tasks: details of trials, qualities of
attempts.
"""

import re
import sqlite3
from collections.abc import Collection, Mapping, Sequence
from typing import Any, get_type_hints

import msgspec

from sar_tui.export.columns import Column, Type

_TYPES: dict[str, Type] = {
    "integer": "integer",
    "real": "number",
    "true": "boolean",
    "false": "boolean",
}
"""The types of SQLite's ``json_each`` that are no text; a list or an object leaves as JSON in a
text.
"""
_OF_PYTHON: dict[type, Type] = {
    msgspec.inspect.IntType: "integer",
    msgspec.inspect.FloatType: "number",
    msgspec.inspect.BoolType: "boolean",
}
_UNITS = {"_ms": "ms", "_ns": "ns", "_cm": "cm", "_hz": "Hz", "_rad_s": "rad/s", "_deg": "deg"}
"""Units, by the ending of a name that has one."""
_UNKNOWN = "Not described: its task no longer declares it."
_NOT_LOADED = "Not described: the task {} cannot be loaded."
_LONGEST_WORD = 32
"""Characters of a text that is a name, such as that of a side or a condition, rather than typed
words.
"""


class Declared(msgspec.Struct, frozen=True):
    """A declared key of a JSON column: its meaning, and the types of its values."""

    meaning: str
    types: frozenset[Type]


def declared_keys(struct: type[msgspec.Struct]) -> dict[str, Declared]:
    """Return the fields of a declaration, such as a task's ``Details``.

    A meaning is that of ``Annotated[float, "From onset to end."]``, or of ``Annotated[float,
    msgspec.Meta(...)]``.
    """
    found = msgspec.inspect.type_info(struct)
    assert isinstance(found, msgspec.inspect.StructType)
    hints = get_type_hints(struct, include_extras=True)
    return {
        field.encode_name: _declared(field.type, _text(hints[field.name])) for field in found.fields
    }


def _text(hint: Any) -> str:
    """Return the text in an annotation; empty if there is none."""
    return next((each for each in getattr(hint, "__metadata__", ()) if isinstance(each, str)), "")


def _declared(kind: msgspec.inspect.Type, meaning: str) -> Declared:
    while isinstance(kind, msgspec.inspect.Metadata):
        meaning = (kind.extra_json_schema or {}).get("description", meaning)
        kind = kind.type
    kinds = kind.types if isinstance(kind, msgspec.inspect.UnionType) else (kind,)
    types = (
        _OF_PYTHON.get(type(each), "string")
        for each in kinds
        if not isinstance(each, msgspec.inspect.NoneType)
    )
    return Declared(meaning, frozenset(types))


_IS_WORDS = (
    "part.value GLOB '*[' || char(32, 9, 10, 13, 160) || ']*'"
    f" OR (part.type='text' AND length(part.value) > {_LONGEST_WORD})"
)
"""SQL that is true for a value that may be words that somebody typed: it has blanks, or is long."""


def columns(
    database: sqlite3.Connection,
    sessions: Sequence[str],
    table: str,
    column: str,
    declared: Mapping[str, Declared],
    other: str = "",
    not_loaded: Collection[str] = (),
) -> dict[str, Column]:
    """Return the columns for the keys of a JSON column, by key: those declared, and others that the
    sessions hold.

    What nobody declares may be anything: its texts leave only if texts are asked for, unless the
    program knows where all of it comes from, and says so in ``other``. Of tasks that cannot be
    loaded, texts leave that are all names.

    Args:
        not_loaded: tasks that cannot be loaded, so that what they declare is not known.
    """
    found: dict[str, set[Type]] = {key: set(one.types) for key, one in declared.items()}
    tasks: dict[str, set[str]] = {}
    # A damaged value has no keys; reading its row reports it.
    value = f"CASE WHEN json_valid({table}.{column}) THEN {table}.{column} ELSE '{{}}' END"
    rows = database.execute(
        f"SELECT part.key, part.type, sessions.task, max({_IS_WORDS})"
        f" FROM {table} JOIN sessions ON sessions.id=session,"
        f" json_each({value}) AS part"
        f" WHERE session IN (SELECT value FROM json_each(?)) AND json_type({value})='object' "
        "GROUP BY 1, 2, 3"
        " ORDER BY part.key",
        (msgspec.json.encode(list(sessions)).decode(),),
    )
    words: set[str] = set()
    for key, kind, task, has_words in rows:
        found.setdefault(key, set())
        words.update([key] if has_words else [])
        tasks.setdefault(key, set()).add(task)
        if kind != "null":
            found[key].add(_TYPES.get(kind, "string"))
    made: dict[str, Column] = {}
    for key, types in found.items():
        type = _common(types)
        is_not_loaded = bool(tasks.get(key)) and tasks[key] <= set(not_loaded)
        is_open = (
            key in declared
            or bool(other)
            or type != "string"
            or (is_not_loaded and key not in words)
        )
        unknown = _NOT_LOADED.format(" or ".join(sorted(tasks[key]))) if is_not_loaded else _UNKNOWN
        made[key] = Column(
            name=_name(column, key, {each.name for each in made.values()}),
            meaning=declared[key].meaning if key in declared else other or unknown,
            type=type,
            unit=next((unit for ending, unit in _UNITS.items() if key.endswith(ending)), ""),
            treatment="open" if is_open else "text",
            tasks=tuple(sorted(tasks.get(key, ()))),
        )
    return made


def _common(types: set[Type]) -> Type:
    """Return the type that holds values of all these types."""
    if types == {"integer", "number"}:
        return "number"
    return next(iter(types)) if len(types) == 1 else "string"


def _name(column: str, key: str, taken: set[str]) -> str:
    """Return a name that R and MATLAB take as well."""
    name = f"{column}_{re.sub(r'[^0-9A-Za-z_]', '_', key)}"
    while name in taken:
        name += "_"
    return name


def written(value: Any) -> str:
    """Return a JSON value as text; a text as it is."""
    return value if isinstance(value, str) else msgspec.json.encode(value).decode()


def value_for(column: Column, value: Any) -> Any:
    """Return a JSON value as a value of a column."""
    if value is None or isinstance(value, str) or column.type != "string":
        return value
    return written(value)

"""Parameters of sessions, and participants' programmes: a row for each value."""

import re
import sqlite3
from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

from sar_tui.export.columns import (
    PARTICIPANT,
    SESSION,
    TASK,
    TO_SESSION,
    Column,
    Reference,
    Stored,
    Table,
    Values,
    in_order,
    stored,
)
from sar_tui.export.damage import Damage
from sar_tui.export.json_columns import written
from sar_tui.export.tables.sessions import TO_PARTICIPANT
from sar_tui.rules.declaration import Field
from sar_tui.store.tables import PROGRAMMES as STORED_PROGRAMMES

Fields = Mapping[str, Mapping[str, Field]]
"""Declared parameters by the name of the task and their own."""

_ADDRESSES = ("outputs", "speech", "imu", "imu_b", "imu_trunk")
"""Parameters whose values may name a computer, a folder or a device after their first word, which
leaves.
"""
_HARMLESS = ("language", "levels")
"""Texts that are no choices, but say nothing about people."""
_VALUES = (
    Column("parameter", "Name of the parameter.", "string", required=True, treatment="open"),
    Column("value", "Its value; several with spaces between them.", "string", treatment="open"),
    Column("text", "Its value, if it is a text that may be anything.", "string"),
    Column("unit", "Unit of the value.", "string", treatment="open"),
    Column("title", "Name for people.", "string", treatment="open"),
)


def parameters(fields: Fields, damage: Damage) -> Table:
    """Return the table of the parameters that sessions had at their start."""
    return Table(
        name="parameters",
        title="A parameter of a session, as it was at its start",
        columns=(SESSION, *_VALUES),
        key=("session", "parameter"),
        rows=partial(_of_session, fields, damage),
        references=(TO_SESSION,),
    )


def programme_parameters(fields: Fields, damage: Damage) -> Table:
    """Return the table of the values in programmes that differ from the defaults."""
    return Table(
        name="programme_parameters",
        title="A parameter of a programme that differs from its default",
        columns=(PARTICIPANT, TASK, _VERSION, *_VALUES),
        key=("participant", "task", "version", "parameter"),
        rows=partial(_of_programmes, fields, damage),
        of="participant",
        references=(Reference(_PROGRAMME, "programmes", _PROGRAMME),),
    )


_VERSION = stored("programmes.version")
_PROGRAMME = STORED_PROGRAMMES.key
_PROGRAMMES = Stored(STORED_PROGRAMMES)
PROGRAMMES = Table(
    name="programmes",
    title=STORED_PROGRAMMES.row,
    columns=_PROGRAMMES.columns,
    key=_PROGRAMME,
    rows=in_order(_PROGRAMMES.columns, _PROGRAMMES.rows),
    of="participant",
    references=(TO_PARTICIPANT,),
)


def _of_session(
    fields: Fields, damage: Damage, database: sqlite3.Connection, session: str
) -> Iterator[Values]:
    for task, found in database.execute(
        "SELECT task, parameters FROM sessions WHERE id=?", (session,)
    ):
        for row in _values(fields.get(task, {}), damage.object_of("parameters", found, "")):
            yield (session, *row)


def _of_programmes(
    fields: Fields, damage: Damage, database: sqlite3.Connection, participant: str
) -> Iterator[Values]:
    for task, version, found in database.execute(
        "SELECT task, version, parameters FROM programmes WHERE participant=? ORDER BY task, "
        "version",
        (participant,),
    ):
        values = damage.object_of("parameters", found, f"task {task}, version {version}")
        for row in _values(fields.get(task, {}), values):
            yield (participant, task, version, *row)


def _values(fields: Mapping[str, Field], values: Mapping[str, Any]) -> Iterator[Values]:
    for name, value in values.items():
        field = fields.get(name)
        parts = value if isinstance(value, list) else [value]
        shown: str | None = " ".join(map(written, parts))
        text = None
        if name in _ADDRESSES:
            shown = " ".join(_first_word(part) for part in parts)
        elif any(isinstance(part, str | dict | list) for part in parts) and not _is_known(
            name, field, value
        ):
            shown, text = None, shown
        title, unit = (field.title, field.unit) if field else ("", "")
        yield name, shown or None, text or None, unit or None, title or None


def _is_known(name: str, field: Field | None, value: object) -> bool:
    """Return True if a text is one of the choices that the task declares, or harmless."""
    return name in _HARMLESS or (
        field is not None and field.kind == "choice" and value in field.choices
    )


def _first_word(address: object) -> str:
    found = re.match(r"[a-z]+", str(address))
    return found[0] if found else "other"

"""Columns and tables of an export, as every format gets them."""

import math
import sqlite3
from collections.abc import Callable, Iterator
from typing import Any, Literal

import msgspec

from sar_tui.export.inventory import LEAVING, Treatment, treatment

Values = tuple[Any, ...]
Type = Literal["string", "integer", "number", "boolean", "datetime"]


class Column(msgspec.Struct, frozen=True):
    """A column.

    Attributes:
        meaning: for the codebook, a sentence or less.
        type: of its values; None stands for a missing one, whatever the type.
        unit: of a number; empty if it has none.
        levels: all values that it can have; empty if they are not known.
        required: True if a value is never missing.
        treatment: what becomes of its values on their way out.
        tasks: the tasks whose rows may have a value; None: all.
    """

    name: str
    meaning: str
    type: Type
    unit: str = ""
    levels: tuple[str, ...] = ()
    required: bool = False
    treatment: Treatment = "text"
    tasks: tuple[str, ...] | None = None


class Reference(msgspec.Struct, frozen=True):
    """Columns whose values are keys of another table."""

    columns: tuple[str, ...]
    table: str
    key: tuple[str, ...]


class Table(msgspec.Struct, frozen=True):
    """A table.

    Attributes:
        title: what a row is, for people.
        columns: in order.
        key: the columns that together name a row.
        rows: yields the rows of one session from the database, or of one participant.
        of: whose rows it yields.
        references: to other tables.
    """

    name: str
    title: str
    columns: tuple[Column, ...]
    key: tuple[str, ...]
    rows: Callable[[sqlite3.Connection, str], Iterator[Values]]
    of: Literal["session", "participant"] = "session"
    references: tuple[Reference, ...] = ()


def stored(
    source: str,
    type: Type,
    meaning: str,
    *,
    name: str = "",
    unit: str = "",
    levels: tuple[str, ...] = (),
    required: bool = False,
) -> Column:
    """Return the column of what the database stores in ``source``: "trials.onset_ns",
    "sessions.machine.cores".

    Its name is the last part of the source if none is given. Raises ValueError if it must not
    leave.
    """
    found = treatment(source)
    if found not in LEAVING:
        raise ValueError(f"{source} must not leave: its treatment is {found}")
    return Column(name or source.rpartition(".")[2], meaning, type, unit, levels, required, found)


SESSION = stored("sessions.id", "string", "Id of the session.", name="session", required=True)
MODE = stored(
    "sessions.mode",
    "string",
    "The session was played by a person (live), by a simulated one, or again from a record.",
    levels=("live", "simulated", "replayed"),
    required=True,
)
TASK = stored("sessions.task", "string", "Name of the task.", required=True)
PARTICIPANT = stored("seats.participant", "string", "Code of the participant.")
SEAT = stored(
    "seats.seat", "string", "The participant's place: A, or B in a task for two.", required=True
)
TO_SESSION = Reference(("session",), "sessions", ("session",))


def as_bool(value: int | None) -> bool | None:
    """Return a boolean that is stored as 1 or 0."""
    return None if value is None else bool(value)


def finite(value: Any) -> Any:
    """Return a number, or None for an infinite one, as earlier versions stored it for a missing
    result.
    """
    return None if isinstance(value, float) and not math.isfinite(value) else value

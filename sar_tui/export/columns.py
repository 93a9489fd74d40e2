"""Columns and tables of an export, as every format gets them: made from what `store.tables`
declares.
"""

import math
import sqlite3
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

import msgspec

from sar_tui.store import tables
from sar_tui.store.tables import LEAVING, TABLES
from sar_tui.store.tables import Privacy as Treatment

if TYPE_CHECKING:
    from sar_tui.export.damage import Damage

Values = tuple[Any, ...]
Row = dict[str, Any]
"""Values by the names of their columns."""
Rows = Callable[[sqlite3.Connection, str], Iterator[Row]]
"""Reads the rows of a session, or of a participant."""
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


def stored(source: str, **changed: Any) -> Column:
    """Return the column of what the database stores in ``source``: "trials.onset_ns",
    "sessions.machine.cores".

    Args:
        changed: what differs in this table from what `store.tables` declares.

    Raises:
        ValueError: it must not leave.
    """
    return msgspec.structs.replace(_column(source, _DECLARED[source]), **changed)


def _declared() -> Iterator[tuple[str, tables.Column]]:
    for table in TABLES.values():
        for column in table.columns:
            yield f"{table.name}.{column.name}", column
            for part in column.parts:
                yield f"{table.name}.{column.name}.{part.name}", part


_DECLARED = dict(_declared())


def _column(source: str, declared: tables.Column) -> Column:
    if declared.privacy not in LEAVING:
        raise ValueError(f"{source} must not leave: its treatment is {declared.privacy}")
    return Column(
        declared.name_in_export,
        declared.meaning,
        _type(declared.type),
        declared.unit,
        declared.levels,
        declared.required,
        declared.privacy,
    )


def _type(stored: tables.Type) -> Type:
    match stored:
        case "json" | "blob":
            return "string"
        case _:
            return stored


class Stored:
    """The columns of a stored table that leave, and its rows.

    Args:
        objects: JSON columns that leave in another way than by the parts that are declared; the
            rows have them whole, by their names.
        changed: what differs from what is declared, by the names of the columns.

    Attributes:
        columns: those that leave, in order, and the declared parts of JSON columns.
    """

    def __init__(
        self,
        table: tables.Table,
        *,
        objects: Sequence[str] = (),
        changed: Mapping[str, Mapping[str, Any]] | None = None,
    ) -> None:
        self._table = table
        self._objects = objects
        self._plain = [column for column in table.columns if column.leaves]
        self._with_parts = [
            column for column in table.columns if column.parts and column.name not in objects
        ]
        differing = changed or {}
        self.columns = tuple(
            msgspec.structs.replace(column, **differing.get(column.name, {}))
            for column in self._columns()
        )

    def _columns(self) -> Iterator[Column]:
        for column in self._table.columns:
            if column.leaves:
                yield _column(f"{self._table.name}.{column.name}", column)
            elif column in self._with_parts:
                for part in column.parts:
                    if part.leaves:
                        yield _column(f"{self._table.name}.{column.name}.{part.name}", part)

    def rows(
        self,
        database: sqlite3.Connection,
        owner: str,
        damage: "Damage | None" = None,
        *,
        order: str = "",
    ) -> Iterator[Row]:
        """Yield the rows of a session, or of a participant, by the names of the columns.

        Args:
            damage: reads the JSON columns; needed if there are any.
            order: a column of the stored table; by default, its key.
        """
        table = self._table
        names = [column.name for column in self._plain]
        names += [column.name for column in self._with_parts]
        names += self._objects
        whose = next(name for name in _OWNERS if name in table.names)
        selected = ", ".join(f'"{name}"' for name in names)
        statement = f"SELECT {selected} FROM {table.name} WHERE {whose}=?"
        for values in database.execute(
            f"{statement} ORDER BY {order or ', '.join(table.key)}", (owner,)
        ):
            found = dict(zip(names, values, strict=True))
            row = {
                column.name_in_export: _plain(column, found[column.name]) for column in self._plain
            }
            for column in self._with_parts:
                row |= _parts(column, found[column.name], damage)
            for name in self._objects:
                assert damage is not None
                row[name] = damage.object_of(name, found[name])
            yield row


_OWNERS = ("session", "participant", "id", "code")
"""Columns that say whose a row is."""


def _plain(column: tables.Column, value: Any) -> Any:
    """Return a value of a column of the database."""
    if column.type == "boolean":
        return as_bool(value)
    return finite(value) if column.type == "number" else value


def _parts(column: tables.Column, value: Any, damage: "Damage | None") -> Row:
    """Return the parts that leave of a JSON value, or of a person's name."""
    leaving = [part for part in column.parts if part.leaves]
    if column.privacy == "person":
        return {part.name_in_export: role(value, part.levels) for part in leaving}
    assert damage is not None
    whole = damage.object_of(column.name, value)
    return {part.name_in_export: _at(whole, part.name) for part in leaving}


def _at(value: Any, path: str) -> Any:
    """Return a part of a JSON object by its path; a list as text, with spaces between."""
    for key in path.split("."):
        value = value.get(key) if isinstance(value, dict) else None
    return " ".join(map(str, value)) if isinstance(value, list) else value


def role(actor: str | None, roles: Sequence[str]) -> str | None:
    """Return the role of an actor, which leaves in place of the name: "operator" for
    "operator.op1". ``other``: the role is not known.
    """
    if not actor:
        return None
    found = actor.partition(".")[0]
    return found if found in roles else "other"


def with_others(
    columns: Iterable[Column], after: Mapping[str, Sequence[Column]]
) -> tuple[Column, ...]:
    """Return columns with others after some of them, by name."""
    made: list[Column] = []
    for column in columns:
        made += [column, *after.get(column.name, ())]
    return tuple(made)


def in_order(
    columns: Sequence[Column], read: Rows
) -> Callable[[sqlite3.Connection, str], Iterator[Values]]:
    """Return what yields the rows that ``read`` yields, as the values of these columns."""
    names = [column.name for column in columns]

    def rows(database: sqlite3.Connection, owner: str) -> Iterator[Values]:
        for row in read(database, owner):
            yield tuple(map(row.get, names))

    return rows


SESSION = stored("sessions.id")
MODE = stored("sessions.mode")
TASK = stored("sessions.task")
PARTICIPANT = stored("seats.participant")
SEAT = stored("seats.seat")
RUN = stored("messages.run")
TO_SESSION = Reference(("session",), "sessions", ("session",))


def codes_by_seat(database: sqlite3.Connection, session: str) -> dict[str, str]:
    """Return the participants' codes of a session, by seat."""
    return dict(database.execute("SELECT seat, participant FROM seats WHERE session=?", (session,)))


def as_bool(value: int | None) -> bool | None:
    """Return a boolean that is stored as 1 or 0."""
    return None if value is None else bool(value)


def finite(value: Any) -> Any:
    """Return a number, or None for one that is not finite, as a database from elsewhere may hold."""
    return None if isinstance(value, float) and not math.isfinite(value) else value

"""Parquet files for many sites: a folder a table, divided by site and month in the way of Hive."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from datetime import datetime
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from sar_tui import __version__
from sar_tui.drivers.installation import pip_install_extra
from sar_tui.export.columns import Column, Table, Type, Values
from sar_tui.export.contents import Contents
from sar_tui.export.errors import ExportError

if TYPE_CHECKING:
    import pyarrow

ROWS = 1 << 12
"""Rows that are in memory as Python's objects at a time."""
_BLOCKS = 32
"""Blocks of so many rows that are written together, as a row group."""
_NO_MONTH = "__HIVE_DEFAULT_PARTITION__"
"""The name that DuckDB, Spark and others read as missing."""
_TYPES: dict[Type, str] = {
    "string": "string",
    "integer": "int64",
    "number": "float64",
    "boolean": "bool_",
}


class ParquetFormat:
    """The same columns with the same types in every export, whatever it holds, so that all are one
    data set.

    Columns that differ between tasks (details of trials and data of their prompts, qualities of
    attempts) are one column each, a JSON object. Columns that do not leave are there, and empty.
    Missing values are null.
    """

    name = "parquet"
    title = "a Parquet data set of many sites, for DuckDB, Spark and Polars"
    by_site = True

    def __init__(self) -> None:
        try:
            import pyarrow  # noqa: F401
        except ImportError:
            raise ExportError(
                f"Parquet needs the package pyarrow. Install it with: {pip_install_extra('lake')}"
            ) from None

    def write(self, contents: Contents, folder: Path, progress: Callable[[], None]) -> None:
        """Write a folder for each table; in it one for the site, and in that one for each month of
        sessions.
        """
        for table in contents.tables:
            shape = _Shape(contents.whole(table), table, contents.problems.append)
            for month, owners in contents.by_month(table):
                path = (
                    folder
                    / table.name
                    / f"site={contents.site}"
                    / _file(table, contents.site, month)
                )
                _write(path, shape, _rows(contents, table, owners, progress))


def _file(table: Table, site: str, month: str) -> str:
    """Return the path of a file in the folder of a site. Its name is unique in the whole data
    set.
    """
    if table.of == "participant":
        return f"{table.name}-{site}.parquet"
    return f"month={month or _NO_MONTH}/{table.name}-{site}-{month or 'none'}.parquet"


def _rows(
    contents: Contents, table: Table, owners: Iterable[str], progress: Callable[[], None]
) -> Iterator[Values]:
    for owner in owners:
        yield from contents.rows(table, owner)
        progress()


class _Shape:
    """Columns of a table in Parquet, and the way from a row to their values. The site is in the
    names of folders.
    """

    def __init__(self, whole: Table, leaving: Table, report: Callable[[str], None]) -> None:
        self._name, self._report = whole.name, report
        self._places = {column.name: index for index, column in enumerate(leaving.columns)}
        self.plain = [
            column for column in whole.columns if column.tasks is None and column.name != "site"
        ]
        objects = [column for column in whole.columns if column.tasks is not None]
        self._objects: dict[str, list[tuple[str, int]]] = {
            name: [] for name in _OBJECTS.get(whole.name, ())
        }
        for column in objects:
            if column.name in self._places:
                self._objects[_object(column)].append((_key(column), self._places[column.name]))
        self.schema = self._schema(whole)

    def _schema(self, whole: Table) -> "pyarrow.Schema":
        import pyarrow as pa

        fields = [_field(column) for column in self.plain]
        fields += [
            pa.field(
                name, pa.string(), metadata={"meaning": "What the task keeps of it, a JSON object."}
            )
            for name in self._objects
        ]
        return pa.schema(
            fields,
            metadata={"title": whole.title, "key": ", ".join(whole.key), "sar_tui": __version__},
        )

    def columns(self, rows: list[Values]) -> "list[pyarrow.Array]":
        """Return the values of rows by column."""
        import pyarrow as pa

        found = list(zip(*rows, strict=True))
        missing = (None,) * len(rows)
        arrays = []
        for column, field in zip(self.plain, self.schema, strict=False):
            values = found[self._places[column.name]] if column.name in self._places else missing
            if column.type == "datetime":
                values = tuple(map(_moment, values))
            arrays.append(self._array(column, values, field.type))
        objects = (
            pa.array([_json(row, places) for row in rows], pa.string())
            for places in self._objects.values()
        )
        return [*arrays, *objects]

    def _array(
        self, column: Column, values: Sequence[Any], kind: "pyarrow.DataType"
    ) -> "pyarrow.Array":
        """Return the values of a column. Those of another type, which are damaged, are missing, and
        reported.
        """
        import pyarrow as pa

        try:
            return pa.array(values, kind)
        except (pa.ArrowException, OverflowError):
            kept = [value if _fits(value, kind) else None for value in values]
            lost = sum(value is not None for value in values) - sum(
                value is not None for value in kept
            )
            self._report(
                f"{self._name}.{column.name}: {lost} value{'' if lost == 1 else 's'} of another "
                "type than "
                f"{column.type} cannot be in a Parquet file, and left out."
            )
            return pa.array(kept, kind)


def _fits(value: object, kind: "pyarrow.DataType") -> bool:
    import pyarrow as pa

    try:
        pa.array([value], kind)
    except (pa.ArrowException, OverflowError):
        return False
    return True


_OBJECTS = {"trials": ("details", "data"), "attempts": ("qualities",)}
"""Columns of tables with what differs between tasks."""


def _object(column: Column) -> str:
    return column.name.partition("_")[0]


def _key(column: Column) -> str:
    return column.name.partition("_")[2]


def _json(row: Values, places: list[tuple[str, int]]) -> str:
    return msgspec.json.encode(
        {key: row[place] for key, place in places if row[place] is not None}
    ).decode()


def _field(column: Column) -> "pyarrow.Field":
    import pyarrow as pa

    kind = (
        pa.timestamp("us", tz="UTC")
        if column.type == "datetime"
        else getattr(pa, _TYPES[column.type])()
    )
    about: dict[str, Any] = {"meaning": column.meaning}
    if column.unit:
        about["unit"] = column.unit
    if column.levels:
        about["levels"] = ", ".join(column.levels)
    return pa.field(column.name, kind, metadata=about)


def _moment(text: str | None) -> datetime | None:
    """Return a stored time; None for a text that is none."""
    try:
        return None if text is None else datetime.fromisoformat(text)
    except ValueError:
        return None


def _write(path: Path, shape: _Shape, rows: Iterator[Values]) -> None:
    """Write rows as a file. A table without rows has a file, too, so that it can be asked for."""
    import pyarrow as pa
    from pyarrow import parquet

    path.parent.mkdir(parents=True, exist_ok=True)
    # the same ones in many rows
    texts = [field.name for field in shape.schema if field.type == pa.string()]
    with parquet.ParquetWriter(
        path, shape.schema, compression="zstd", use_dictionary=texts
    ) as file:
        blocks = iter(lambda: list(islice(rows, ROWS)), [])
        while group := [
            pa.record_batch(shape.columns(each), schema=shape.schema)
            for each in islice(blocks, _BLOCKS)
        ]:
            file.write_table(pa.Table.from_batches(group).combine_chunks())

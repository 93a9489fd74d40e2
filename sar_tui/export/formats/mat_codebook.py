"""The codebook of MATLAB files: every field of every table."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import msgspec

from sar_tui.export.columns import Column, Table
from sar_tui.export.csv_file import CsvWriter
from sar_tui.export.formats.mat_values import is_stamp, matlab_type, short_names

STREAM = {
    "stream": ("double", "Number of the stream in its session, from 1."),
    "columns": ("cell", "Names of the columns of data."),
    "units": ("cell", "Units of the columns of data."),
    "data": ("double", "The samples, a row for each."),
    "at_ns": ("int64", "When each was measured, steady clock of the run."),
    "host_ns": ("int64", "When each arrived, same clock."),
}
"""The fields of a sensor's struct: type and meaning."""
_MISSING = {"double": "NaN", "int64": "intmin('int64')", "cell": "empty"}


class Entry(msgspec.Struct, frozen=True):
    """A line of the codebook.

    Attributes:
        name: in MATLAB.
        full_name: in the other formats.
        unit, levels: empty if there is none.
    """

    variable: str
    table: str
    name: str
    full_name: str
    type: str
    missing: str
    unit: str
    levels: str
    meaning: str


def entries(table: Table) -> Iterator[Entry]:
    """Yield a line for each field of a table's struct, in order."""
    short = short_names(column.name for column in table.columns)
    for column in table.columns:
        yield _entry(
            table,
            short[column.name],
            column.name,
            matlab_type(column),
            column.unit,
            column.meaning,
            column.levels,
        )
        if in_seconds(table, column):
            meaning = f"{column.name} in seconds since the first run of the session began."
            yield _entry(table, seconds_name(column), seconds_name(column), "double", "s", meaning)


def sample_entries(table: Table) -> Iterator[Entry]:
    """Yield a line for each field of a sensor's struct, and for each column of its samples."""
    for name, (type, meaning) in STREAM.items():
        yield _entry(table, name, name, type, "ns" if name.endswith("_ns") else "", meaning)
    began = "When it was measured, in seconds since the first run of the session began."
    yield _entry(table, "data(:, 1)", "at_s", "double", "s", began)
    for number, column in enumerate(measured(table), 2):
        yield _entry(
            table, f"data(:, {number})", column.name, "double", column.unit, column.meaning
        )


def measured(table: Table) -> list[Column]:
    """Return the columns of samples that are one matrix."""
    return [column for column in table.columns if column.type == "number"]


def in_seconds(table: Table, column: Column) -> bool:
    """Return True if the stamps of a column leave in seconds as well. Those in details and data may
    be durations.
    """
    is_clock = is_stamp(column) and not column.name.startswith(("details_", "data_", "qualities_"))
    return is_clock and any(other.name == "run" for other in table.columns)


def seconds_name(column: Column) -> str:
    """Return the name of the field that has a column's stamps in seconds."""
    return f"{column.name.removesuffix('_ns')}_s"


def write_codebook(path: Path, lines: Iterable[Entry]) -> None:
    """Write the codebook as a CSV file."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = CsvWriter(file)
        writer.row(Entry.__struct_fields__)
        writer.rows(msgspec.structs.astuple(line) for line in lines)


def _entry(
    table: Table,
    name: str,
    full_name: str,
    type: str,
    unit: str,
    meaning: str,
    levels: Sequence[str] = (),
) -> Entry:
    variable = "participants" if table.of == "participant" else "session"
    return Entry(
        variable,
        table.name,
        name,
        full_name,
        type,
        _MISSING[type],
        unit,
        "; ".join(levels),
        meaning,
    )

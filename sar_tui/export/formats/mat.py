"""A MATLAB file a session, which Octave reads as well, and a codebook of all columns."""

import hashlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import chain, groupby, islice
from operator import itemgetter
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from sar_tui.drivers.installation import pip_install_extra
from sar_tui.export.columns import Column, Table, Values
from sar_tui.export.contents import Contents
from sar_tui.export.csv_file import CsvWriter
from sar_tui.export.errors import ExportError
from sar_tui.export.session_clock import SessionClock, session_clock

_HEAD, _HEAD_LENGTH = b"MATLAB 5.0 MAT-file, exported by sar-tui", 116
_SAMPLES = "imu"
_BLOCK = 1 << 16
"""Number of samples that become a matrix at once."""
_TOO_LARGE = (
    "Session {} is left out: it is larger than a MATLAB file of version 5 can be (4 GB). "
    "Export it as csv."
)


class MatFormat:
    """A struct a session (MAT-file version 5) with a struct for each table, whose fields are its
    columns.

    Stamps in ns are int64, and in seconds since the session began doubles; other numbers and
    booleans are doubles, NaN if missing; texts are cells. The samples of a sensor are one matrix. A
    session is in memory while it is written.
    """

    name = "mat"
    title = "a MATLAB file a session, with codebook.csv"

    def write(self, contents: Contents, folder: Path, progress: Callable[[], None]) -> None:
        """Write a file for each session, one for the participants, and the codebook."""
        try:
            from scipy.io import savemat
            from scipy.io.matlab import MatWriteError
        except ImportError as error:
            raise ExportError(
                "The format mat needs the package scipy. Install it with: "
                f"{pip_install_extra('export')}"
            ) from error
        of_persons = [table for table in contents.tables if table.of == "participant"]
        of_sessions = [table for table in contents.tables if table.of == "session"]
        path = folder / "participants.mat"
        savemat(path, {"participants": _participants(contents, of_persons, progress)})
        _replace_head(path)
        for session in contents.owners(of_sessions[0]):
            path = folder / f"session_{session}.mat"
            try:
                savemat(path, {"session": _session(contents, session, of_sessions, progress)})
            except MatWriteError:
                path.unlink()
                contents.problems.append(_TOO_LARGE.format(session))
            else:
                _replace_head(path)
        lines = (
            sample_entries(table) if table.name == _SAMPLES else entries(table)
            for table in contents.tables
        )
        write_codebook(folder / "codebook.csv", chain.from_iterable(lines))


def _replace_head(path: Path) -> None:
    """Replace the words at the beginning of a MATLAB file: those of scipy have the date of the
    export.
    """
    with path.open("r+b") as file:
        file.write(_HEAD.ljust(_HEAD_LENGTH))


def _participants(contents: Contents, tables: Sequence[Table], progress: Callable[[], None]) -> Any:
    fields = {}
    for table in tables:
        rows = [
            row
            for person in contents.owners(table)
            for row in _read(contents, table, person, progress)
        ]
        fields[table.name] = _table(table, rows)
    return _with_units(fields, tables)


def _session(
    contents: Contents, session: str, tables: Sequence[Table], progress: Callable[[], None]
) -> Any:
    clock = session_clock(contents, session)
    fields: dict[str, Any] = {}
    runs: dict[int, int] = {}
    for table in tables:
        rows = _read(contents, table, session, progress)
        if table.name == _SAMPLES:
            fields[table.name] = _streams(table, rows, clock, runs)
            continue
        found = list(rows)
        if table.name == "imu_streams":
            names = [column.name for column in table.columns]
            runs = dict(map(itemgetter(names.index("stream"), names.index("run")), found))
        fields[table.name] = _table(table, found, clock)
    return _with_units(fields, tables)


def _read(
    contents: Contents, table: Table, owner: str, progress: Callable[[], None]
) -> Iterator[Values]:
    yield from contents.rows(table, owner)
    progress()


def _with_units(fields: Mapping[str, Any], tables: Iterable[Table]) -> Any:
    """Return a struct of tables, with the units of their columns in the field ``units``."""
    units = {
        table.name: {entry.name: entry.unit for entry in entries(table) if entry.unit}
        for table in tables
        if table.name != _SAMPLES  # each stream has its own
    }
    return {**fields, "units": units}


def _table(table: Table, rows: Sequence[Values], clock: SessionClock | None = None) -> Any:
    """Return the struct of a table: a field for each column, and one in seconds for each of its
    stamps.
    """
    values = list(zip(*rows, strict=True)) or [()] * len(table.columns)
    names = [column.name for column in table.columns]
    short = short_names(names)
    made: dict[str, Any] = {}
    for column, found in zip(table.columns, values, strict=True):
        made[short[column.name]] = column_of(column, found)
        if clock is not None and in_seconds(table, column):
            # an attempt may have begun in an earlier run
            own = f"{column.name.removesuffix('_ns')}_run"
            runs = values[names.index(own if own in names else "run")]
            made[seconds_name(column)] = numbers(
                [clock.seconds(*each) for each in zip(runs, found, strict=True)]
            )
    return made


def _streams(
    table: Table, rows: Iterable[Values], clock: SessionClock, runs: Mapping[int, int]
) -> Any:
    """Return the samples of a session, a struct for each of its sensors.

    Args:
        runs: the run of each stream.
    """
    names = [column.name for column in table.columns]
    columns = measured(table)
    pick = itemgetter(*(names.index(column.name) for column in columns))
    at, host = names.index("at_ns"), names.index("host_ns")
    made: list[dict[str, Any]] = []
    for stream, samples in groupby(rows, itemgetter(names.index("stream"))):
        zero = clock.zero(runs.get(stream))
        data: list[Any] = []
        at_ns: list[Any] = []
        host_ns: list[Any] = []
        while block := list(islice(samples, _BLOCK)):
            at_ns.append(stamps([row[at] for row in block]))
            host_ns.append(stamps([row[host] for row in block]))
            at_s = np.full((len(block), 1), np.nan) if zero is None else (at_ns[-1] - zero) / 1e9
            data.append(
                np.hstack([at_s, numbers([pick(row) for row in block]).reshape(len(block), -1)])
            )
        made.append(
            {
                "stream": float(stream),
                "columns": names_row(["at_s", *(column.name for column in columns)]),
                "units": names_row(["s", *(column.unit for column in columns)]),
                "data": stacked(data),
                "at_ns": stacked(at_ns),
                "host_ns": stacked(host_ns),
            }
        )
    return struct_row(made, STREAM)


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


MISSING_NS = -(2**63)
"""Missing value of int64, which has no NaN: MATLAB's ``intmin("int64")``."""
_LONGEST = 31
Array = npt.NDArray[Any]


def short_names(names: Iterable[str]) -> dict[str, str]:
    """Return a name of at most 31 characters for each name, the same in every export."""
    short: dict[str, str] = {}
    for name in names:
        digest = hashlib.sha256(name.encode()).hexdigest()
        short[name] = name if len(name) <= _LONGEST else f"{name[: _LONGEST - 7]}_{digest[:6]}"
    return short


def is_stamp(column: Column) -> bool:
    """Return True if a column holds whole nanoseconds, which a double may be too short for."""
    return column.type == "integer" and column.unit == "ns"


def matlab_type(column: Column) -> str:
    """Return the type of a column's values in MATLAB."""
    if is_stamp(column):
        return "int64"
    return "cell" if column.type in ("string", "datetime") else "double"


def column_of(column: Column, values: Sequence[Any]) -> Array:
    """Return the values of a column as a matrix of one column, or as cells."""
    match matlab_type(column):
        case "int64":
            return stamps(values)
        case "cell":
            return texts(values)
        case _:
            return numbers(values)


def numbers(values: Sequence[Any]) -> Array:
    """Return doubles, NaN for what is missing or no number."""
    try:
        found = np.array(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        found = np.array([_number(value) for value in values], dtype=np.float64)
    return found.reshape(-1, 1)


def _number(value: object) -> float:
    try:
        return float(value) if isinstance(value, int | float) else np.nan
    except OverflowError:
        return np.nan


def stamps(values: Sequence[Any]) -> Array:
    """Return whole nanoseconds as int64."""
    try:
        found = np.array(values, dtype=np.int64)
    except (TypeError, ValueError, OverflowError):
        found = np.array([_stamp(value) for value in values], dtype=np.int64)
    return found.reshape(-1, 1)


def _stamp(value: object) -> int:
    return value if isinstance(value, int) and MISSING_NS <= value < -MISSING_NS else MISSING_NS


def texts(values: Sequence[Any]) -> Array:
    """Return cells; a missing text is empty."""
    cells = np.empty((len(values), 1), dtype=object)
    for row, value in enumerate(values):
        cells[row, 0] = text("" if value is None else str(value))
    return cells


def text(value: str) -> "str | Array":
    """Return a text as characters if all are ASCII, else its bytes in UTF-8 as a row of uint8.

    MATLAB, Octave and Python read each other's characters beyond ASCII differently, or cut them.
    """
    if value.isascii() and "\0" not in value:
        return value
    return np.frombuffer(value.encode("utf-8", "replace"), dtype=np.uint8).reshape(1, -1)


def stacked(blocks: list[Array]) -> Array:
    """Return matrices below each other. The list is emptied, so that the rows are in memory
    once.
    """
    row = sum(map(len, blocks))
    made = np.empty((row, blocks[0].shape[1]), dtype=blocks[0].dtype, order="F")
    while blocks:
        block = blocks.pop()
        row -= len(block)
        made[row : row + len(block)] = block
    return made


def names_row(names: Sequence[str]) -> Array:
    """Return cells in a row."""
    cells = np.empty((1, len(names)), dtype=object)
    cells[0, :] = names
    return cells


def struct_row(elements: Sequence[Mapping[str, Any]], names: Iterable[str]) -> Array:
    """Return a row of structs that have these fields; scipy makes a single one from a
    dictionary.
    """
    made = np.empty((1, len(elements)), dtype=[(name, object) for name in names])
    for number, element in enumerate(elements):
        for name in names:
            made[name][0, number] = element[name]
    return made

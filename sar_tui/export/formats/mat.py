"""A MATLAB file a session, which Octave reads as well, and a codebook of all columns."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import chain, groupby, islice
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np

from sar_tui.drivers.installation import pip_install_extra
from sar_tui.export.columns import Table, Values
from sar_tui.export.contents import Contents
from sar_tui.export.errors import ExportError
from sar_tui.export.formats.mat_codebook import (
    STREAM,
    entries,
    in_seconds,
    measured,
    sample_entries,
    seconds_name,
    write_codebook,
)
from sar_tui.export.formats.mat_values import (
    column_of,
    names_row,
    numbers,
    short_names,
    stacked,
    stamps,
    struct_row,
)
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

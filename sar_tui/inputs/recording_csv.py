"""Recordings as CSV."""

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from sar_tui.inputs.imu import SourceError
from sar_tui.inputs.recording_table import NAMES, ROWS, Table, check_names

if TYPE_CHECKING:
    from _csv import Reader


def csv_tables(path: Path) -> Iterator[Table]:
    """Yield the rows of a file in blocks; none if it has a header only.

    Raises SourceError for any fault of the text, and OSError.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(file)
            try:
                yield from _tables(path, reader)
            except csv.Error as error:
                raise SourceError(
                    f"{path}, line {reader.line_num}: this is not CSV: {error}."
                ) from error
    except UnicodeDecodeError as error:
        line = _undecodable_line(path)
        raise SourceError(
            f"{path}, line {line}: this is not UTF-8 text; save the file as CSV UTF-8."
        ) from error


def _tables(path: Path, reader: "Reader") -> Iterator[Table]:
    header: list[str] = []
    wanted: dict[str, int] = {}
    rows: list[list[float]] = []
    lines: list[int] = []
    for row in reader:
        if not any(cell.strip() for cell in row):
            continue
        if not header:
            header = [cell.strip() for cell in row]
            check_names(path, header)
            wanted = {name: header.index(name) for name in NAMES if name in header}
            continue
        if len(row) != len(header):
            raise SourceError(
                f"{path}, line {reader.line_num}: {len(row)} values for {len(header)} columns; a "
                "line needs a "
                "value for each column, commas between them, and points in decimals."
            )
        try:
            rows.append([float(row[index]) for index in wanted.values()])
        except ValueError:
            _refuse_row(
                f"{path}, line {reader.line_num}",
                {name: row[index] for name, index in wanted.items()},
            )
        lines.append(reader.line_num)
        if len(rows) == ROWS:
            yield _table(path, list(wanted), rows, lines)
            rows, lines = [], []
    if not header:
        raise SourceError(f"{path} is empty.")
    if rows:
        yield _table(path, list(wanted), rows, lines)


def _table(path: Path, names: list[str], rows: list[list[float]], lines: list[int]) -> Table:
    values = np.array(rows, dtype=float)
    columns = {name: values[:, column] for column, name in enumerate(names)}
    return Table(path, columns, "line", np.array(lines, dtype=np.int64))


def _refuse_row(where: str, cells: dict[str, str]) -> NoReturn:
    for name, cell in cells.items():
        try:
            float(cell)
        except ValueError as error:
            raise SourceError(
                f'{where}: "{cell.strip()}" in the column {name} is not a number.'
            ) from error
    raise AssertionError(where)


def _undecodable_line(path: Path) -> int:
    """Return the number of the first line that is not UTF-8."""
    with path.open("rb") as file:
        return next((number for number, line in enumerate(file, 1) if not _is_utf_8(line)), 1)


def _is_utf_8(line: bytes) -> bool:
    try:
        line.decode()
    except UnicodeDecodeError:
        return False
    return True

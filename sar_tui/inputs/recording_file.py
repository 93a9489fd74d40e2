"""Recordings of motion sensors in files: CSV, and NPZ with arrays of the same names.

``t`` in s; ``wx,wy,wz`` the angular rate; ``ax,ay,az`` the acceleration and ``mx,my,mz`` the
magnetic field in gauss, both optional.
"""

import csv
import zipfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from itertools import chain, islice
from pathlib import Path
from typing import IO, TYPE_CHECKING, Literal, NamedTuple, NoReturn

import msgspec
import numpy as np
import numpy.typing as npt

from sar_tui.inputs.imu import ACCELERATION_UNITS, RATE_UNITS, SourceError
from sar_tui.motion.faults import turns_too_far
from sar_tui.motion.samples import SAMPLE, Floats, Samples, join

if TYPE_CHECKING:
    from _csv import Reader


ROWS = 1 << 16
"""Number of rows in a block."""
VECTORS = {
    "rate": ("wx", "wy", "wz"),
    "acceleration": ("ax", "ay", "az"),
    "field": ("mx", "my", "mz"),
}
NAMES = ("t", *(name for vector in VECTORS.values() for name in vector))


class Table(NamedTuple):
    """Columns of one or more rows, shape (n,) each, and the numbers of the rows for error
    messages.
    """

    path: Path
    columns: dict[str, Floats]
    row_word: str
    row_numbers: npt.NDArray[np.int64]

    def refuse(self, row: int, what: str) -> NoReturn:
        """Raise SourceError for a row."""
        raise SourceError(f"{self.path}, {self.row_word} {self.row_numbers[row]}: {what}")


def check_names(path: Path, names: list[str]) -> None:
    """Raise SourceError if the names of a file's columns are not those of a recording."""
    if twice := sorted({name for name in names if name in NAMES and names.count(name) > 1}):
        raise SourceError(f"{path}: there are two columns {', '.join(twice)}; keep one of each.")
    needed = ["t", *VECTORS["rate"]]
    for vector in VECTORS.values():
        needed += [
            name for name in vector if name not in needed and not set(vector).isdisjoint(names)
        ]
    if missing := [name for name in needed if name not in names]:
        commas = (
            " Separate columns by commas, not by semicolons or tabs." if len(names) == 1 else ""
        )
        raise SourceError(f"{path}: the columns {', '.join(missing)} are missing.{commas}")


FEWEST = 20
"""Fewer samples cannot hold a reach."""
LOWEST_RATE_HZ = 20.0
"""Slower recordings miss details of the movement."""
LARGEST = 1 << 30
"""Largest file that is read as a whole, in bytes, packed and unpacked: days of samples."""

_LATEST_S = 9e9
_TOO_LARGE = 1e30
FASTEST_RAD_S = 50.0
"""Beyond the range of motion sensors (2000 deg/s are 35 rad/s)."""


class Units(msgspec.Struct, frozen=True, kw_only=True):
    """Units of a file's numbers."""

    acceleration: Literal["m/s2", "g"] = "m/s2"
    rate: Literal["rad/s", "deg/s"] = "rad/s"


SI = Units()


def read_recording(path: Path, units: Units = SI) -> Samples:
    """Read a file as samples, dtype SAMPLE, converted to m/s² and rad/s; ``at`` and ``host`` are
    its ``t`` in ns.

    Raises SourceError for any fault: one sentence with the file, the line, and what to do.
    """
    _check_file(path)
    if path.stat().st_size > LARGEST:
        raise SourceError(f"{path} is larger than 1 GiB: cut it into several recordings.")
    if _is_npz(path) and unpacked_bytes(path) > LARGEST:
        raise SourceError(f"{path} unpacks to more than 1 GiB: cut it into several recordings.")
    return join(read_blocks(path, units))


def read_blocks(path: Path, units: Units = SI) -> Iterator[Samples]:
    """Yield the samples of a file of any size, in blocks of `recording_table.ROWS`.

    Raises SourceError as `read_recording`, when it comes to the fault.
    """
    _check_file(path)
    last: int | None = None
    try:
        for table in npz_tables(path) if _is_npz(path) else csv_tables(path):
            samples = _samples(table, units, last)
            if last is None:
                _check_amount(path, samples)
            last = int(samples["at"][-1])
            yield samples
    except OSError as error:
        raise SourceError(f"{path} cannot be read: {error.strerror}.") from error
    if last is None:
        raise _too_few(path, 0)


def refuse_degrees(path: Path, samples: Samples) -> None:
    """Raise SourceError for samples that are most likely in deg/s: faster or farther than any hand
    turns.
    """
    rate = samples["rate"].astype(float)
    fastest = float(np.abs(rate).max(initial=0.0))
    if fastest <= FASTEST_RAD_S and turns_too_far(samples["at"] / 1e9, rate):
        raise SourceError(
            f"{path} turns by more than two whole turns within a few seconds, farther than any "
            "hand: it must be in deg/s. Set the unit (--rate deg/s, or recorded:FILE?rate=deg/s)."
        )
    if fastest > FASTEST_RAD_S:
        raise SourceError(
            f"{path} turns at up to {fastest:.0f} rad/s, faster than any hand: it must be in "
            "deg/s. Set the unit (--rate deg/s, or recorded:FILE?rate=deg/s)."
        )


def _is_npz(path: Path) -> bool:
    return path.suffix.lower() == ".npz"


def _check_file(path: Path) -> None:
    try:
        if not path.exists():
            raise SourceError(f"There is no file {path}.")
        if not path.is_file():
            raise SourceError(f"{path} is not a file: name a recording, FILE.csv or FILE.npz.")
        if not path.stat().st_size:
            raise SourceError(f"{path} is empty.")
    except OSError as error:
        raise SourceError(f"{path} cannot be read: {error.strerror}.") from error


def _check_amount(path: Path, first: Samples) -> None:
    """Raise SourceError if the first block of a file shows that it holds too few samples, or too
    few a second.
    """
    if len(first) < FEWEST:
        raise _too_few(path, len(first))
    rate_hz = 1e9 / float(np.median(np.diff(first["at"])))
    if rate_hz < LOWEST_RATE_HZ:
        raise SourceError(
            f"{path} holds {rate_hz:.3g} samples a second (t is in seconds); at least "
            f"{LOWEST_RATE_HZ:g} are needed."
        )


def _too_few(path: Path, count: int) -> SourceError:
    return SourceError(f"{path} holds {count} samples; at least {FEWEST} are needed.")


def _samples(table: Table, units: Units, last: int | None) -> Samples:
    """Return a table's samples, which follow one at ``last`` (ns). Raises SourceError if one is
    invalid.
    """
    time_s = table.columns["t"]
    if (row := _first(~(np.abs(time_s) < _LATEST_S))) is not None:
        table.refuse(row, f"the time {time_s[row]:g} cannot be; t is in seconds.")
    at = np.rint(time_s * 1e9).astype(np.int64)
    steps = np.diff(at, prepend=at[0] - 1 if last is None else last)
    if (row := _first(steps <= 0)) is not None:
        what = "is before" if steps[row] else "is the same as"
        table.refuse(
            row, f"the time {time_s[row]:.9g} {what} that of the sample above; it must be later."
        )
    samples = np.zeros(len(at), dtype=SAMPLE)
    samples["at"] = samples["host"] = at
    samples["device_ms"] = time_s * 1e3
    factors = {
        "rate": RATE_UNITS[units.rate],
        "acceleration": ACCELERATION_UNITS[units.acceleration],
        "field": 1.0,
    }
    for field, names in VECTORS.items():
        if names[0] not in table.columns:
            samples[field] = np.nan
            continue
        for axis, name in enumerate(names):
            column = table.columns[name] * factors[field]
            wrong = ~(np.abs(column) < _TOO_LARGE)
            if field != "rate":
                wrong &= ~np.isnan(column)
            if (row := _first(wrong)) is not None:
                table.refuse(
                    row,
                    f"{table.columns[name][row]:g} in the column {name} is no measurement; leave "
                    "it out.",
                )
            samples[field][:, axis] = column
    return samples


def _first(wrong: npt.NDArray[np.bool_]) -> int | None:
    return int(np.argmax(wrong)) if wrong.any() else None


def csv_tables(path: Path) -> Iterator[Table]:
    """Yield the rows of a file in blocks; none if it has a header only.

    Raises SourceError for any fault of the text, and OSError.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            yield from _tables(path, file)
    except UnicodeDecodeError as error:
        line = _undecodable_line(path)
        raise SourceError(
            f"{path}, line {line}: this is not UTF-8 text; save the file as CSV UTF-8."
        ) from error


def _tables(path: Path, file: IO[str]) -> Iterator[Table]:
    reader = csv.reader(file)
    with _csv_errors(path, reader):
        header = next((_stripped(row) for row in reader if any(_stripped(row))), None)
    if header is None:
        raise SourceError(f"{path} is empty.")
    check_names(path, header)
    wanted = {name: header.index(name) for name in NAMES if name in header}
    before = reader.line_num
    while lines := list(islice(file, ROWS)):
        values = _numbers(lines, len(header), list(wanted.values()))
        if values is None:
            rest = csv.reader(chain(lines, file))
            yield from _checked_tables(path, rest, len(header), wanted, before)
            return
        numbers = np.arange(before + 1, before + 1 + len(lines))
        yield _table(path, list(wanted), values, numbers)
        before += len(lines)


def _stripped(row: list[str]) -> list[str]:
    return [cell.strip() for cell in row]


def _numbers(lines: list[str], width: int, columns: list[int]) -> Floats | None:
    """Return the numbers in some columns of lines; None if a line has another number of columns, or
    is not as simple as most.
    """
    if any(line.count(",") != width - 1 or '"' in line for line in lines):
        return None
    try:
        found: Floats = np.loadtxt(lines, delimiter=",", usecols=columns, ndmin=2, comments=None)
    except ValueError:
        return None
    return found


@contextmanager
def _csv_errors(path: Path, reader: "Reader", before: int = 0) -> Iterator[None]:
    """Raise SourceError for what is not CSV, in a reader that begins after some lines."""
    try:
        yield
    except csv.Error as error:
        line = before + reader.line_num
        raise SourceError(f"{path}, line {line}: this is not CSV: {error}.") from error


def _checked_tables(
    path: Path, reader: "Reader", width: int, wanted: dict[str, int], before: int
) -> Iterator[Table]:
    """Yield rows that may be blank, quoted or faulty. Raises SourceError for any fault."""
    rows: list[list[float]] = []
    numbers: list[int] = []
    with _csv_errors(path, reader, before):
        for row in reader:
            if not any(cell.strip() for cell in row):
                continue
            line = before + reader.line_num
            if len(row) != width:
                raise SourceError(
                    f"{path}, line {line}: {len(row)} values for {width} columns; a line needs a "
                    "value for each column, commas between them, and points in decimals."
                )
            try:
                rows.append([float(row[index]) for index in wanted.values()])
            except ValueError:
                cells = {name: row[index] for name, index in wanted.items()}
                _refuse_row(f"{path}, line {line}", cells)
            numbers.append(line)
            if len(rows) == ROWS:
                yield _table(path, list(wanted), np.array(rows), np.array(numbers))
                rows, numbers = [], []
    if rows:
        yield _table(path, list(wanted), np.array(rows), np.array(numbers))


def _table(path: Path, names: list[str], values: Floats, numbers: npt.NDArray[np.int64]) -> Table:
    columns = {name: values[:, column] for column, name in enumerate(names)}
    return Table(path, columns, "line", numbers)


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


def npz_tables(path: Path) -> Iterator[Table]:
    """Yield the rows of a file in blocks. Raises SourceError for any fault."""
    try:
        with zipfile.ZipFile(path) as archive, ExitStack() as opened:
            names = [name.removesuffix(".npy") for name in archive.namelist()]
            check_names(path, names)
            columns = {
                name: _Column(path, name, opened.enter_context(archive.open(f"{name}.npy")))
                for name in NAMES
                if name in names
            }
            length = columns["t"].length
            if uneven := [name for name, column in columns.items() if column.length != length]:
                raise SourceError(f"{path}: the arrays {', '.join(uneven)} are not as long as t.")
            for first in range(0, length, ROWS):
                last = min(first + ROWS, length)
                block = {name: column.read(last - first) for name, column in columns.items()}
                yield Table(path, block, "sample", np.arange(first + 1, last + 1))
    except (SourceError, OSError):
        raise
    except Exception as error:
        raise SourceError(f"{path} is not an NPZ file, or it is damaged: {error}.") from error


def unpacked_bytes(path: Path) -> int:
    """Return the size of all arrays in a file as it claims; 0 if it is damaged."""
    try:
        with zipfile.ZipFile(path) as archive:
            return sum(member.file_size for member in archive.infolist())
    except zipfile.BadZipFile:
        return 0


class _Column:
    """An array in an archive, read from its beginning to its end, without unpickling."""

    def __init__(self, path: Path, name: str, member: IO[bytes]) -> None:
        self._member = member
        try:
            version = np.lib.format.read_magic(member)
            read = (
                np.lib.format.read_array_header_1_0
                if version == (1, 0)
                else np.lib.format.read_array_header_2_0
            )
            shape, _, self._dtype = read(member)
        except ValueError as error:
            raise SourceError(f"{path}: the array {name} cannot be read: {error}.") from error
        if self._dtype.hasobject:
            raise SourceError(
                f"{path}: the array {name} cannot be read: Object arrays are not numbers."
            )
        if len(shape) != 1 or self._dtype.kind not in "fiu":
            raise SourceError(f"{path}: the array {name} must be one row of numbers.")
        (self.length,) = shape

    def read(self, count: int) -> Floats:
        """Return the next numbers. Raises ValueError if there are fewer."""
        data = self._member.read(count * self._dtype.itemsize)
        values = np.frombuffer(data, self._dtype)
        if len(values) < count:
            raise ValueError("an array ends early")
        return values.astype(float)

"""Recordings of motion sensors in files: CSV, and NPZ with arrays of the same names.

``t`` in s; ``wx,wy,wz`` the angular rate; ``ax,ay,az`` the acceleration and ``mx,my,mz`` the magnetic field in gauss,
both optional.
"""

import csv
import io
import math
import zipfile
from pathlib import Path
from typing import Literal, NamedTuple, NoReturn

import msgspec
import numpy as np
import numpy.typing as npt

from sar_tui.inputs.imu import SourceError
from sar_tui.motion.samples import SAMPLE, Floats, Samples

FEWEST = 20
"""Fewer samples cannot hold a reach."""
LOWEST_RATE_HZ = 20.0
"""Slower recordings miss details of the movement."""
LARGEST = 1 << 30
"""Largest file in bytes, packed and unpacked: days of samples."""
VECTORS = {"rate": ("wx", "wy", "wz"), "acceleration": ("ax", "ay", "az"), "field": ("mx", "my", "mz")}
NAMES = ("t", *(name for vector in VECTORS.values() for name in vector))

_LATEST_S = 9e9
_TOO_LARGE = 1e30
FASTEST_RAD_S = 50.0
"""Beyond the range of motion sensors (2000 deg/s are 35 rad/s)."""
_RATE = {"rad/s": 1.0, "deg/s": math.pi / 180}
_ACCELERATION = {"m/s2": 1.0, "g": 9.80665}


class Units(msgspec.Struct, frozen=True, kw_only=True):
    """Units of a file's numbers."""

    acceleration: Literal["m/s2", "g"] = "m/s2"
    rate: Literal["rad/s", "deg/s"] = "rad/s"


class _Table(NamedTuple):
    """The columns of a file, shape (n,) each, and the numbers of its rows for error messages."""

    path: Path
    columns: dict[str, Floats]
    row_word: str
    row_numbers: npt.NDArray[np.int64]

    def refuse(self, row: int, what: str) -> NoReturn:
        raise SourceError(f"{self.path}, {self.row_word} {self.row_numbers[row]}: {what}")


SI = Units()


def read_recording(path: Path, units: Units = SI) -> Samples:
    """Read a file as samples, dtype SAMPLE, converted to m/s² and rad/s; ``at`` and ``host`` are its ``t`` in ns.

    Raises SourceError for any fault: one sentence with the file, the line, and what to do.
    """
    try:
        if not path.exists():
            raise SourceError(f"There is no file {path}.")
        if not path.is_file():
            raise SourceError(f"{path} is not a file: name a recording, FILE.csv or FILE.npz.")
        if path.stat().st_size > LARGEST:
            raise SourceError(f"{path} is larger than 1 GiB: cut it into several recordings.")
        data = path.read_bytes()
    except OSError as error:
        raise SourceError(f"{path} cannot be read: {error.strerror}.") from error
    if not data.strip():
        raise SourceError(f"{path} is empty.")
    table = _npz(path, data) if path.suffix.lower() == ".npz" else _csv(path, data)
    return _samples(table, units)


def refuse_degrees(path: Path, samples: Samples) -> None:
    """Raise SourceError for samples faster than any sensor measures, which are most likely in deg/s."""
    fastest = float(np.abs(samples["rate"]).max(initial=0.0))
    if fastest > FASTEST_RAD_S:
        raise SourceError(
            f"{path} turns at up to {fastest:.0f} rad/s, faster than any hand: it must be in deg/s. Set the unit "
            "(--rate deg/s, or recorded:FILE?rate=deg/s)."
        )


def _csv(path: Path, data: bytes) -> _Table:
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise SourceError(f"{path}, line {line}: this is not UTF-8 text; save the file as CSV UTF-8.") from error
    reader = csv.reader(io.StringIO(text, newline=""))
    header: list[str] = []
    wanted: dict[str, int] = {}
    rows: list[list[float]] = []
    lines: list[int] = []
    try:
        for row in reader:
            if not any(cell.strip() for cell in row):
                continue
            if not header:
                header = [cell.strip() for cell in row]
                _check_names(path, header)
                wanted = {name: header.index(name) for name in NAMES if name in header}
                continue
            if len(row) != len(header):
                raise SourceError(
                    f"{path}, line {reader.line_num}: {len(row)} values for {len(header)} columns; a line needs a "
                    "value for each column, commas between them, and points in decimals."
                )
            try:
                rows.append([float(row[index]) for index in wanted.values()])
            except ValueError:
                _refuse_row(f"{path}, line {reader.line_num}", {name: row[index] for name, index in wanted.items()})
            lines.append(reader.line_num)
    except csv.Error as error:
        raise SourceError(f"{path}, line {reader.line_num}: this is not CSV: {error}.") from error
    if not header:
        raise SourceError(f"{path} is empty.")
    values = np.array(rows, dtype=float).reshape(len(rows), len(wanted))
    columns = {name: values[:, column] for column, name in enumerate(wanted)}
    return _Table(path, columns, "line", np.array(lines, dtype=np.int64))


def _refuse_row(where: str, cells: dict[str, str]) -> NoReturn:
    for name, cell in cells.items():
        try:
            float(cell)
        except ValueError as error:
            raise SourceError(f'{where}: "{cell.strip()}" in the column {name} is not a number.') from error
    raise AssertionError(where)


def _npz(path: Path, data: bytes) -> _Table:
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if sum(member.file_size for member in archive.infolist()) > LARGEST:
                raise SourceError(f"{path} unpacks to more than 1 GiB: cut it into several recordings.")
            names = [name.removesuffix(".npy") for name in archive.namelist()]
            _check_names(path, names)
            columns = {name: _array(path, archive, name) for name in NAMES if name in names}
    except SourceError:
        raise
    except Exception as error:
        raise SourceError(f"{path} is not an NPZ file, or it is damaged: {error}.") from error
    if uneven := [name for name, column in columns.items() if len(column) != len(columns["t"])]:
        raise SourceError(f"{path}: the arrays {', '.join(uneven)} are not as long as t.")
    return _Table(path, columns, "sample", np.arange(1, len(columns["t"]) + 1))


def _array(path: Path, archive: zipfile.ZipFile, name: str) -> Floats:
    """Read one column without unpickling."""
    with archive.open(f"{name}.npy") as member:
        try:
            array = np.lib.format.read_array(member, allow_pickle=False)
        except ValueError as error:
            raise SourceError(f"{path}: the array {name} cannot be read: {error}.") from error
    if array.ndim != 1 or array.dtype.kind not in "fiu":
        raise SourceError(f"{path}: the array {name} must be one row of numbers.")
    return array.astype(float)


def _check_names(path: Path, names: list[str]) -> None:
    if twice := sorted({name for name in names if name in NAMES and names.count(name) > 1}):
        raise SourceError(f"{path}: there are two columns {', '.join(twice)}; keep one of each.")
    needed = ["t", *VECTORS["rate"]]
    for vector in VECTORS.values():
        needed += [name for name in vector if name not in needed and not set(vector).isdisjoint(names)]
    if missing := [name for name in needed if name not in names]:
        commas = " Separate columns by commas, not by semicolons or tabs." if len(names) == 1 else ""
        raise SourceError(f"{path}: the columns {', '.join(missing)} are missing.{commas}")


def _samples(table: _Table, units: Units) -> Samples:
    """Return a table's samples. Raises SourceError if one is invalid."""
    time_s = table.columns["t"]
    if (row := _first(~(np.abs(time_s) < _LATEST_S))) is not None:
        table.refuse(row, f"the time {time_s[row]:g} cannot be; t is in seconds.")
    at = np.rint(time_s * 1e9).astype(np.int64)
    if (row := _first(np.diff(at) <= 0)) is not None:
        what = "is the same as" if at[row] == at[row + 1] else "is before"
        table.refuse(row + 1, f"the time {time_s[row + 1]:.9g} {what} that of the sample above; it must be later.")
    samples = np.zeros(len(at), dtype=SAMPLE)
    samples["at"] = samples["host"] = at
    samples["device_ms"] = time_s * 1e3
    factors = {"rate": _RATE[units.rate], "acceleration": _ACCELERATION[units.acceleration], "field": 1.0}
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
                table.refuse(row, f"{table.columns[name][row]:g} in the column {name} is no measurement; leave it out.")
            samples[field][:, axis] = column
    if len(at) < FEWEST:
        raise SourceError(f"{table.path} holds {len(at)} samples; at least {FEWEST} are needed.")
    rate_hz = 1e9 / float(np.median(np.diff(at)))
    if rate_hz < LOWEST_RATE_HZ:
        raise SourceError(
            f"{table.path} holds {rate_hz:.3g} samples a second (t is in seconds); "
            f"at least {LOWEST_RATE_HZ:g} are needed."
        )
    return samples


def _first(wrong: npt.NDArray[np.bool_]) -> int | None:
    return int(np.argmax(wrong)) if wrong.any() else None

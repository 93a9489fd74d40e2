"""Recordings of motion sensors in files: CSV, and NPZ with arrays of the same names.

``t`` in s; ``wx,wy,wz`` the angular rate; ``ax,ay,az`` the acceleration and ``mx,my,mz`` the
magnetic field in gauss, both optional.
"""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import msgspec
import numpy as np
import numpy.typing as npt

from sar_tui.inputs.imu import SourceError
from sar_tui.inputs.recording_csv import csv_tables
from sar_tui.inputs.recording_npz import npz_tables, unpacked_bytes
from sar_tui.inputs.recording_table import VECTORS, Table
from sar_tui.motion.faults import turns_too_far
from sar_tui.motion.samples import SAMPLE, Samples, join

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
_RATE = {"rad/s": 1.0, "deg/s": math.pi / 180}
_ACCELERATION = {"m/s2": 1.0, "g": 9.80665}


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
            "hand: it must be in "
            "deg/s. Set the unit (--rate deg/s, or recorded:FILE?rate=deg/s)."
        )
    if fastest > FASTEST_RAD_S:
        raise SourceError(
            f"{path} turns at up to {fastest:.0f} rad/s, faster than any hand: it must be in "
            "deg/s. Set the unit "
            "(--rate deg/s, or recorded:FILE?rate=deg/s)."
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
        "rate": _RATE[units.rate],
        "acceleration": _ACCELERATION[units.acceleration],
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

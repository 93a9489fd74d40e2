"""Recordings as NPZ: an array for each column."""

import zipfile
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import IO

import numpy as np

from sar_tui.inputs.imu import SourceError
from sar_tui.inputs.recording_table import NAMES, ROWS, Table, check_names
from sar_tui.motion.samples import Floats


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

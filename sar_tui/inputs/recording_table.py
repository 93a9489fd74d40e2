"""A recording's columns as read from its file, a block of rows at a time."""

from pathlib import Path
from typing import NamedTuple, NoReturn

import numpy as np
import numpy.typing as npt

from sar_tui.inputs.imu import SourceError
from sar_tui.motion.samples import Floats

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

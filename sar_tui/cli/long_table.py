"""A table of any length, in plain lines: thousands of rows take no longer than their printing."""

from collections.abc import Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

_GAP = "   "
_ROWS = 1000
"""Number of rows that are printed at once."""


def print_table(
    out: "Console",
    columns: Sequence[str],
    rows: Sequence[Sequence[object]],
    *,
    right: Sequence[str] = (),
) -> None:
    """Print a table. Columns in ``right`` are right-aligned; an empty cell is a dash; a long line
    is not folded.

    The name of a column may have several lines.
    """
    cells = [["–" if cell in (None, "") else str(cell) for cell in row] for row in rows]
    heads = list(zip_longest(*(column.split("\n") for column in columns), fillvalue=""))
    widths = [max(map(len, column)) for column in zip(*heads, *cells, strict=True)]

    def line(row: Sequence[str]) -> str:
        aligned = (
            cell.rjust(width) if name in right else cell.ljust(width)
            for name, cell, width in zip(columns, row, widths, strict=True)
        )
        return _GAP.join(aligned).rstrip()

    rule = "─" * (sum(widths) + len(_GAP) * (len(columns) - 1))
    lines = [*map(line, heads), rule, *map(line, cells)]
    for first in range(0, len(lines), _ROWS):
        out.print(
            "\n".join(lines[first : first + _ROWS]), markup=False, highlight=False, soft_wrap=True
        )

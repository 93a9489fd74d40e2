"""Columns as MATLAB has them: matrices of numbers, cells of texts, names of at most 31
characters.
"""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from sar_tui.export.columns import Column

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

"""Files with values between tabs, and the JSON that describes their columns."""

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import msgspec

from sar_tui.export.columns import Column
from sar_tui.export.csv_file import cell

MISSING = "n/a"
_ESCAPES = str.maketrans({"\t": "\\t", "\n": "\\n", "\r": "\\r", "\\": "\\\\"})
_BOOLEANS = {"true": "Yes.", "false": "No."}


def text(of: str) -> str:
    """Return a text as it is written.

    Tabs, line ends and backslashes are written as in JSON, and a quote at its beginning, which
    other programs would take for the beginning of a quoted text. Formulas and other control
    characters are written as in CSV.
    """
    if of.isalnum():
        return of
    escaped: str = cell(of.translate(_ESCAPES))
    return f"\\{escaped}" if escaped.startswith('"') else escaped or MISSING


_WRITTEN: dict[type, Callable[[Any], str]] = {
    float: repr,
    int: repr,
    str: text,
    bool: {True: "true", False: "false"}.__getitem__,
    type(None): lambda _: MISSING,
}
"""Writers of values by their types; millions of samples pass here."""


def line(values: Iterable[Any]) -> str:
    """Return a line of values."""
    return "\t".join([_WRITTEN[type(value)](value) for value in values]) + "\n"


def seconds(ns: int) -> str:
    """Return nanoseconds as seconds, with all digits."""
    whole, rest = divmod(abs(ns), 10**9)
    return f"{'-' if ns < 0 else ''}{whole}.{rest:09d}"


def write_rows(path: Path, head: Iterable[str], rows: Iterable[Iterable[Any]]) -> None:
    """Write a header line and rows."""
    with path.open("w", encoding="utf-8", newline="") as file:
        file.write(line(head))
        file.writelines(map(line, rows))


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write a JSON file for people to read."""
    path.write_bytes(msgspec.json.format(msgspec.json.encode(content)) + b"\n")


def described(columns: Iterable[Column]) -> dict[str, Any]:
    """Return what a JSON sidecar says of columns: meaning, unit, and levels."""
    return {column.name: description(column) for column in columns}


def description(column: Column, levels: Mapping[str, str] | None = None) -> dict[str, Any]:
    """Return what a JSON sidecar says of a column.

    BIDS takes a column with units for one of numbers: the unit of a text, such as several stamps
    with spaces between them, is part of the description.

    Args:
        levels: the meaning of each level, where the name of a level does not say enough.
    """
    if levels is None:
        levels = (
            _BOOLEANS
            if column.type == "boolean"
            else {text(level): level for level in column.levels}
        )
    is_number = column.type in ("integer", "number")
    return {
        "Description": column.meaning
        if is_number or not column.unit
        else f"{column.meaning} Unit: {column.unit}.",
        **({"Units": column.unit} if is_number and column.unit else {}),
        **({"Levels": levels} if levels else {}),
    }

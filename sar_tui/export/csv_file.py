"""CSV files, as all that the program writes: texts in them are texts, whatever program opens the
file.
"""

import csv
import re
from collections.abc import Iterable
from typing import Any, TextIO

from sar_tui.model.visible_text import visible

_FORMULA = re.compile(r"[=+\-@\t\r].", re.DOTALL)
"""Beginning of a text that spreadsheets compute
(https://owasp.org/www-community/attacks/CSV_Injection).

A sign alone is none, nor is a number.
"""
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_KEPT = "\n\t"
"""Control characters that may stand in a cell, beside the line end CR LF."""
_PLAIN = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _.,:/-]*")
"""A text that needs no care; millions pass here."""


def cell(value: Any) -> Any:
    """Return a value as it is written: of a text, a formula begins with an apostrophe, and controls
    are visible signs.

    Numbers stay as they are, negative ones and those in texts too.
    """
    if not isinstance(value, str) or _PLAIN.fullmatch(value):
        return value
    shown = "\r\n".join(visible(line, _KEPT) for line in value.split("\r\n"))
    return f"'{shown}" if _FORMULA.match(value) and not _NUMBER.fullmatch(value) else shown


class CsvWriter:
    """Writes rows into an open text file (``newline=""``), by RFC 4180."""

    def __init__(self, file: TextIO) -> None:
        self._writer = csv.writer(file)

    def row(self, values: Iterable[Any]) -> None:
        self._writer.writerow([cell(value) for value in values])

    def rows(self, rows: Iterable[Iterable[Any]]) -> None:
        self._writer.writerows([cell(value) for value in row] for row in rows)

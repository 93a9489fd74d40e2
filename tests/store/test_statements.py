"""Statements of SQL, as every Python takes them."""

import re
from pathlib import Path

import sar_tui

ESCAPES = "terminal_output.py"
"""Its question marks are those of escape sequences."""


def test_no_placeholder_is_numbered() -> None:
    """Python 3.14 takes a number for a name, and refuses the values if they are not a
    dictionary.
    """
    for path in Path(sar_tui.__file__).parent.rglob("*.py"):
        found = re.search(r"[=(, <>]\?[1-9]", path.read_text(encoding="utf-8"))
        assert path.name == ESCAPES or not found, f"{path}: {found}"

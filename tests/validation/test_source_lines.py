"""Counting lines of code."""

import textwrap
from pathlib import Path

import pytest

from sar_tui.validation.modularity import count, source_lines


@pytest.mark.parametrize(
    ("source", "lines"),
    [
        ("", 0),
        ("\n\n# a comment\n", 0),
        ('"""Documentation\nof a module."""\n', 0),
        ("a = 1  # with a comment\n\nb = 2\n", 2),
        ("f(\n    1,\n\n    # why\n    2,\n)\n", 4),
        ('a = """one\ntwo\nthree"""\n', 3),
        ('LIMIT = 3\n"""What it is."""\n', 1),
        ('def f():\n    """Does it."""\n    return 1\n', 2),
        ('def f():\n    """Does\n    it."""\n', 1),
        ('f"{a}"\n', 1),
        ("a = 1; b = 2\n", 1),
    ],
)
def test_only_code_is_counted(source: str, lines: int) -> None:
    assert count(source) == lines


def test_a_file_is_read_in_its_own_encoding(tmp_path: Path) -> None:
    path = tmp_path / "old.py"
    path.write_bytes(
        textwrap.dedent("# -*- coding: latin-1 -*-\nname = 'Gr\xfc\xdfe'\n").encode("latin-1")
    )
    assert source_lines(path) == 1

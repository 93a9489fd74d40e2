"""Docstrings open with a verb or a noun phrase."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.examples import first

ROOT = Path(__file__).parent.parent
DISALLOWED_OPENING = re.compile(r"(What|Who|Whom|Whose|Whether|Of|Where|How|That)\b")


def first_lines(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the line number and the first line of every docstring, of a class's attributes as
    well.
    """
    tree = ast.parse(path.read_text("utf-8"))
    for node in ast.walk(tree):
        match node:
            case ast.Expr(value=ast.Constant(value=str(text))):
                yield node.lineno, text.strip().partition("\n")[0]


@pytest.mark.parametrize("folder", first(4, ["sar_tui", "tasks", "benchmarks", "docs", "tests"]))
def test_docstrings_open_with_a_verb_or_a_noun_phrase(folder: str) -> None:
    found = [
        f"{path.relative_to(ROOT)}:{number}: {line}"
        for path in sorted((ROOT / folder).rglob("*.py"))
        for number, line in first_lines(path)
        if DISALLOWED_OPENING.match(line)
    ]
    assert not found, "Open with a verb or a noun phrase:\n" + "\n".join(found)

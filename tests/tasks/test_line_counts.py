"""docs/line-counts.md tells how long the bundled and the documented tasks are, to within a few
lines.
"""

import ast
import re
from pathlib import Path

from tests.documented import FILES

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "line-counts.md").read_text(encoding="utf-8")
ROWS = re.findall(
    r"^\| [^|]+ \| (?:(\d+) \(`(\w+)`\)|–) \| (?:(\d+) \(`(\w+)`\)|–) \|", PAGE, re.MULTILINE
)
SLACK = 10


def lines_of_code(source: str) -> int:
    """Return the number of lines that are neither blank nor comments nor parts of docstrings."""
    texts = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Expr)]
    told = {
        line
        for node in texts
        if isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
        for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)
    }
    lines = [
        line.strip() for number, line in enumerate(source.splitlines(), 1) if number not in told
    ]
    return len([line for line in lines if line and not line.startswith("#")])


def test_our_own_numbers_hold() -> None:
    bundled = {name: int(number) for number, name, _, _ in ROWS if name}
    documented = {name: int(number) for _, _, number, name in ROWS if name}
    assert {
        "flanker",
        "gonogo",
        "stop_signal",
        "posner",
        "nback",
        "srtt",
        "tapping",
        "tracking_tempo",
    } == set(bundled)
    for name, number in bundled.items():
        files = [path for path in (ROOT / "tasks" / name).glob("*.py") if path.name != "effect.py"]
        counted = sum(lines_of_code(path.read_text(encoding="utf-8")) for path in files)
        assert abs(counted - number) <= SLACK, f"{name} has {counted} lines"
    for name, number in documented.items():
        assert abs(lines_of_code(FILES[name, "task.py"]) - number) <= SLACK

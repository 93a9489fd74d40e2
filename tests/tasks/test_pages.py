"""Pages of the documentation about tasks name tasks that exist, and tell their lengths."""

import re
from pathlib import Path

from sar_tui.plugins import Catalogue
from sar_tui.validation.modularity import count
from tests.documented import FILES

ROOT = Path(__file__).parents[2]
SLACK = 10
"""Lines of code by which a task may differ from the page."""


def page(name: str) -> str:
    return (ROOT / "docs" / name).read_text(encoding="utf-8")


def test_the_page_of_paradigms_names_each_bundled_task_and_none_that_does_not_exist(
    catalogue: Catalogue,
) -> None:
    tables, _, _ = page("paradigms.md").partition("## What stays impossible")
    lines = re.findall(r"^\| (?!paradigm)(.*?) \|$", tables, re.MULTILINE)
    rows = [line.split(" | ") for line in lines]
    assert len(rows) >= 40
    assert {len(row) for row in rows} <= {2, 3}
    to_copy = " ".join(row[-1] for row in rows if len(row) == 3)
    named = {name for name in re.findall(r"`([^`]+)`", to_copy) if not name.startswith("sar-tui ")}
    assert named <= set(catalogue.task_names())
    assert [name for name in catalogue.task_names() if f"`{name}`" not in tables] == []


def test_the_page_of_line_counts_tells_how_long_our_tasks_are() -> None:
    rows = re.findall(
        r"^\| [^|]+ \| (?:(\d+) \(`(\w+)`\)|–) \| (?:(\d+) \(`(\w+)`\)|–) \|",
        page("line-counts.md"),
        re.MULTILINE,
    )
    bundled = {name: int(number) for number, name, _, _ in rows if name}
    documented = {name: int(number) for _, _, number, name in rows if name}
    assert len(bundled) == 8
    for name, number in bundled.items():
        files = [path for path in (ROOT / "tasks" / name).glob("*.py") if path.name != "effect.py"]
        counted = sum(count(path.read_text(encoding="utf-8")) for path in files)
        assert abs(counted - number) <= SLACK, f"{name} has {counted} lines"
    for name, number in documented.items():
        assert abs(count(FILES[name, "task.py"]) - number) <= SLACK

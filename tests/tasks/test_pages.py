"""The page of paradigms names tasks that exist."""

import re
from pathlib import Path

from sar_tui.plugins import Catalogue

ROOT = Path(__file__).parents[2]


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

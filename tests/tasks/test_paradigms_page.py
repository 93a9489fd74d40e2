"""docs/paradigms.md names tasks that exist."""

import re
from pathlib import Path

from sar_tui.plugins import Catalogue

PAGE = (Path(__file__).parents[2] / "docs" / "paradigms.md").read_text(encoding="utf-8")
TABLES, _, _ = PAGE.partition("## What stays impossible")
ROWS = [row.split(" | ") for row in re.findall(r"^\| (?!paradigm)(.*?) \|$", TABLES, re.MULTILINE)]


def test_each_task_to_copy_is_bundled_or_documented(catalogue: Catalogue) -> None:
    assert len(ROWS) >= 40
    assert {len(row) for row in ROWS} <= {2, 3}
    named = {name for row in ROWS for name in re.findall(r"`([^`]+)`", row[-1]) if len(row) == 3}
    commands = {name for name in named if name.startswith("sar-tui ")}
    assert named - commands <= set(catalogue.task_names())
    assert {"stop_signal", "tracking_tempo", "posner"} <= named


def test_each_bundled_task_is_named(catalogue: Catalogue) -> None:
    assert [name for name in catalogue.task_names() if f"`{name}`" not in TABLES] == []

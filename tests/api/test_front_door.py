"""`sar_tui.api` has all that a plug-in needs, loads little, and is all that an example imports."""

import ast
import importlib
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from textwrap import dedent

import msgspec
import pytest

import sar_tui
from sar_tui import api
from sar_tui.loop import topics
from sar_tui.loop.bus import Service, Topic
from sar_tui.model import messages
from tests.api.pages import python_blocks

ROOT = Path(__file__).parents[2]
DOORS = ("export", "node", "output", "policy", "sensor", "task", "testing", "view")
MODULES = [f"sar_tui.api.{door}" for door in DOORS]
LIST = Path(__file__).with_name(f"names-{api.API}.txt")
"""The names of each module: add new ones, take none away."""


def internal_imports(source: str) -> Iterator[str]:
    """Return the modules of the package behind `sar_tui.api` that a text imports."""
    for node in ast.walk(ast.parse(dedent(source))):
        if isinstance(node, ast.ImportFrom) and not node.level:
            imported = [node.module or ""]
        elif isinstance(node, ast.Import):
            imported = [alias.name for alias in node.names]
        else:
            continue
        for name in imported:
            package, *rest = name.split(".")
            if package == "sar_tui" and rest[:1] != ["api"]:
                yield name


@pytest.mark.parametrize(
    "page", ["README.md", *sorted(p.name for p in (ROOT / "docs").glob("*.md"))]
)
def test_code_of_the_pages_imports_nothing_else(page: str) -> None:
    folder = ROOT if page == "README.md" else ROOT / "docs"
    blocks = python_blocks((folder / page).read_text(encoding="utf-8"))
    assert [name for block in blocks for name in internal_imports(block)] == []


def test_what_a_new_task_begins_with_imports_nothing_else() -> None:
    sources = [
        *(ROOT / "sar_tui" / "cli" / "new_task").glob("*.py"),
        *(ROOT / "tasks").rglob("*.py"),
    ]
    assert any("Task" in path.read_text() for path in sources)
    assert {
        path.name: found for path in sources if (found := [*internal_imports(path.read_text())])
    } == {}


@pytest.mark.parametrize("name", MODULES)
def test_every_name_can_be_imported(name: str) -> None:
    module = importlib.import_module(name)
    assert [name for name in module.__all__ if getattr(module, name, None) is None] == []
    assert len(set(module.__all__)) == len(module.__all__)


def test_no_name_has_left() -> None:
    """A name that leaves belongs into RETIRED first. SAR_TUI_UPDATE_SNAPSHOTS=1 adds new names."""
    lines = LIST.read_text(encoding="utf-8").splitlines()
    known = {door: names.split() for door, _, names in (line.partition(": ") for line in lines)}
    names = {
        door: sorted({*module.__all__, *module.RETIRED})
        for door, module in zip(DOORS, map(importlib.import_module, MODULES), strict=True)
    }
    assert {door: left for door in known if (left := {*known[door]} - {*names[door]})} == {}
    if os.environ.get("SAR_TUI_UPDATE_SNAPSHOTS"):
        listed = (f"{door}: {' '.join(found)}\n" for door, found in names.items())
        LIST.write_text("".join(listed), encoding="utf-8")
    else:
        assert names == known, "add the new names with SAR_TUI_UPDATE_SNAPSHOTS=1"


def test_a_node_has_all_topics_services_and_messages() -> None:
    from sar_tui.api import node

    declared = {name for name, value in vars(topics).items() if isinstance(value, Topic | Service)}
    sent = {
        name
        for name, value in vars(messages).items()
        if isinstance(value, type) and issubclass(value, msgspec.Struct)
    }
    assert declared | sent <= {*node.__all__}, "list the new ones in sar_tui/api/node.py"


def loaded_by(statement: str) -> set[str]:
    """Return the modules that a new Python has after a statement."""
    run = subprocess.run(
        [
            sys.executable,
            "-c",
            f"import sys, json; {statement}; print(json.dumps(list(sys.modules)))",
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    return set(json.loads(run.stdout))


def test_a_task_loads_little_and_its_settings_no_numbers_or_screens() -> None:
    heavy = {"numpy", "textual", "rich", "asyncio", "sqlite3", "importlib.metadata"}
    few = {*heavy, "pathlib", "hashlib", "statistics", "difflib", "random"}
    behind = {"sar_tui.loop.bus", "sar_tui.rules.parameters", "sar_tui.model.messages"}
    by_msgspec = loaded_by("import msgspec")
    shortest = "from sar_tui.api.task import Metric, Result, Stimulus, Task"
    assert not (loaded_by(shortest) - by_msgspec) & (few | behind)
    assert (
        not loaded_by("from sar_tui.api.task import TaskParameters, Node, Staircase, meta") & heavy
    )
    assert not loaded_by("import sar_tui.api.node, sar_tui.api.sensor, sar_tui.api.output") & {
        "numpy", "textual"
    }  # fmt: skip


def test_a_retired_name_works_and_warns_of_its_replacement(monkeypatch: pytest.MonkeyPatch) -> None:
    from sar_tui.api import task

    monkeypatch.setitem(task.RETIRED, "Chance", "RandomStreams")
    with pytest.warns(
        DeprecationWarning, match="Chance of sar_tui.api.task leaves with API 2. Use RandomStreams"
    ) as told:
        from sar_tui.api.task import Chance  # type: ignore[attr-defined]
    assert Chance is task.RandomStreams
    assert str(told[0].message) == (
        "Chance of sar_tui.api.task leaves with API 2. Use RandomStreams instead."
    )
    assert told[0].filename == __file__


def test_an_unknown_name_is_an_ordinary_error() -> None:
    with pytest.raises(ImportError, match="cannot import name 'Tasks'"):
        from sar_tui.api.task import Tasks  # type: ignore[attr-defined]  # noqa: F401


def test_the_number_is_that_of_the_package() -> None:
    assert api.API is sar_tui.API

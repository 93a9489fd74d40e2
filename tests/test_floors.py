"""Importing the framework loads no screen, device, database or network module."""

import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
LIST_LOADED_MODULES = """
import importlib, json, pkgutil, sys
package = importlib.import_module(sys.argv[1])
modules = pkgutil.walk_packages(package.__path__, f"{sys.argv[1]}.") if sys.argv[2:] else ()
for module in modules:
    importlib.import_module(module.name)
print(json.dumps(sorted(sys.modules)))
"""


def loaded(package: str, *how: str) -> set[str]:
    """Return the modules that importing a package loads, with ``"whole"`` all of its own."""
    command = [sys.executable, "-c", LIST_LOADED_MODULES, package, *how]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return set(json.loads(done.stdout))


def test_the_framework_stands_alone() -> None:
    names = loaded("sar_tui.loop", "whole")
    assert {"sar_tui.loop.bus", "sar_tui.loop.nodes.event_handler"} <= names
    others = "textual rich Phidget22 sqlite3 sqlite_utils zenoh numpy filelock typer"
    assert not names & set(others.split())


@pytest.mark.parametrize("folder", ["sar_tui", "benchmarks", "docs", "tasks"])
def test_a_program_begins_when_its_whole_module_is_read(folder: str) -> None:
    for path in sorted((ROOT / folder).rglob("*.py")):
        statements = ast.parse(path.read_text("utf-8")).body
        begins = [
            number
            for number, each in enumerate(statements, 1)
            if isinstance(each, ast.If) and "__name__" in ast.unparse(each.test)
        ]
        assert begins in ([], [len(statements)]), path


@pytest.mark.parametrize("package", ["sar_tui.store", "sar_tui.plugins", "sar_tui.runs.run"])
def test_packages_that_work_without_a_screen_load_none(package: str) -> None:
    assert "textual" not in loaded(package)

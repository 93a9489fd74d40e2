"""Importing the framework loads no screen, device, database or network module."""

import json
import subprocess
import sys

import pytest

LIST_LOADED_MODULES = """
import importlib, json, pkgutil, sys
package = importlib.import_module(sys.argv[1])
found = [package.__name__]
for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
    importlib.import_module(module.name)
    found.append(module.name)
print(json.dumps({"found": found, "loaded": sorted(sys.modules)}))
"""


def loaded(package: str) -> tuple[list[str], set[str]]:
    """Return the modules of a package, and the top-level names of all modules that importing them
    loads.
    """
    run = subprocess.run(
        [sys.executable, "-c", LIST_LOADED_MODULES, package],
        capture_output=True,
        text=True,
        check=True,
    )
    answer = json.loads(run.stdout)
    return answer["found"], {name.split(".")[0] for name in answer["loaded"]}


def test_the_framework_stands_alone() -> None:
    modules, names = loaded("sar_tui.loop")
    assert {"sar_tui.loop.bus", "sar_tui.loop.nodes.event_handler"} <= set(modules)
    forbidden = {
        "textual",
        "rich",
        "Phidget22",
        "sqlite3",
        "sqlite_utils",
        "zenoh",
        "numpy",
        "filelock",
        "typer",
    }
    assert not forbidden & names


@pytest.mark.parametrize("package", ["sar_tui.store", "sar_tui.plugins", "sar_tui.runs.run"])
def test_packages_that_work_without_a_screen_load_none(package: str) -> None:
    run = subprocess.run(
        [sys.executable, "-c", f"import sys, {package}; print('textual' in sys.modules)"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout.strip() == "False"

"""`make run` installs what the program needs, and `make test` what developers need besides."""

import os
import re
import shutil
import subprocess
from importlib.metadata import distribution
from pathlib import Path

import pytest
from packaging.requirements import Requirement

REPOSITORY = Path(__file__).parents[1]
MOST_PACKAGES = 55
OF_PIP = ("pip", "setuptools")

pytestmark = pytest.mark.skipif(not shutil.which("make"), reason="make is not installed")


def test_the_tests_for_each_python_exist() -> None:
    """With a file that is missing, pytest runs none of them."""
    listed = re.findall(r"tests/[\w/.]+", (REPOSITORY / ".ci" / "pythons").read_text())
    assert len(listed) > 15
    assert [name for name in listed if not (REPOSITORY / name).exists()] == []


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    for name in ("Makefile", "pyproject.toml"):
        shutil.copy(REPOSITORY / name, tmp_path)
    return tmp_path


def test_each_target_installs_what_it_needs_and_is_not_yet_there(checkout: Path) -> None:
    def installs(*targets: str) -> list[str]:
        """Return the extras that make would install for each target; empty if nothing."""
        found = []
        for target in targets:
            words = ["make", "-n", target]
            done = subprocess.run(words, cwd=checkout, capture_output=True, text=True, check=True)
            _, is_installed, after = done.stdout.partition("--editable '.[")
            found.append(after.partition("]")[0] if is_installed else "")
        return found

    assert installs("run", "demo", "test") == [
        "link,serve,letterbox",
        "link,serve,letterbox",
        "dev",
    ]
    (checkout / ".venv").mkdir()
    (checkout / ".venv" / "program").touch()
    assert installs("run", "demo", "lint") == ["", "", "dev"]
    ready = checkout / ".venv" / "ready"
    ready.touch()
    assert installs("run", "demo", "test", "lint") == [""] * 4
    older = (checkout / "pyproject.toml").stat().st_mtime - 60
    os.utime(ready, (older, older))
    assert installs("run", "test") == ["dev", "dev"]


def test_the_program_needs_few_packages() -> None:
    needed = {"sar-tui", *OF_PIP}
    wanted = [("sar-tui", frozenset({"link", "serve", ""}))]
    while wanted:
        name, extras = wanted.pop()
        for line in distribution(name).requires or ():
            requirement = Requirement(line)
            marker = requirement.marker
            if marker is None or any(marker.evaluate({"extra": extra}) for extra in extras or {""}):
                known = requirement.name.lower().replace("_", "-")
                if known not in needed or requirement.extras:
                    needed.add(known)
                    wanted.append((requirement.name, frozenset(requirement.extras) - {""} | {""}))
    assert len(needed) <= MOST_PACKAGES, sorted(needed)

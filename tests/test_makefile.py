"""`make run` installs what the program needs, and `make test` what developers need besides."""

import os
import re
import shutil
import subprocess
import time
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


def extras_to_install(checkout: Path, target: str) -> str:
    """Return what make would install for a target; empty if nothing."""
    done = subprocess.run(
        ["make", "-n", target], cwd=checkout, capture_output=True, text=True, check=True
    )
    _, found, after = done.stdout.partition("--editable '.[")
    return after.partition("]")[0] if found else ""


def have(checkout: Path, stamp: str, *, age_s: int = 0) -> None:
    """Leave the stamp of an environment, some seconds older than what it must have if ``age_s`` is
    given.
    """
    path = checkout / ".venv" / stamp
    path.parent.mkdir(exist_ok=True)
    path.touch()
    made = (checkout / "pyproject.toml").stat().st_mtime - age_s if age_s else time.time()
    os.utime(path, (made, made))


@pytest.mark.parametrize(
    ("target", "extras"), [("run", "link,serve"), ("demo", "link,serve"), ("test", "dev")]
)
def test_a_fresh_checkout_installs_what_the_target_needs(
    checkout: Path, target: str, extras: str
) -> None:
    assert extras_to_install(checkout, target) == extras


def test_what_the_program_needs_is_installed_once_and_tests_add_the_rest(checkout: Path) -> None:
    have(checkout, "program")
    assert [extras_to_install(checkout, target) for target in ("run", "demo", "lint")] == [
        "",
        "",
        "dev",
    ]


def test_an_environment_for_developers_has_all_that_the_program_needs(checkout: Path) -> None:
    have(checkout, "ready")
    assert [extras_to_install(checkout, target) for target in ("run", "demo", "test", "lint")] == [
        ""
    ] * 4
    have(checkout, "ready", age_s=60)
    assert [extras_to_install(checkout, target) for target in ("run", "test")] == ["dev", "dev"]


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

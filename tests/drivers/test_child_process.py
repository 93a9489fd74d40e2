"""Child programs: none imports a module of the folder that the program was started in."""

import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

import sar_tui
from sar_tui.cli.common import Home
from sar_tui.cli.serve import _program
from sar_tui.drivers import child_process
from sar_tui.link import broker_process
from sar_tui.outputs.sound import child
from sar_tui.plugins import Catalogue
from sar_tui.timing.closed_loop import BASELINE, SAR_TUI, Block
from sar_tui.validation import modularity

HOSTILE = (
    "sar_tui",
    "queue",
    "numpy",
    "msgspec",
    "json",
    "sqlite3",
    "typing_extensions",
    "textual",
    "tasks",
)
"""Modules that would run in place of the libraries of these names."""
PROGRAMS = {
    "voice": lambda folder: child.VOICE,
    "tones": lambda folder: child.TONES,
    "broker": lambda folder: broker_process.PROGRAM,
    "probe": lambda folder: child_process.python("sar_tui.link.client"),
    "browser": lambda folder: [*_program("operator", None, None, Home(folder)), "--help"],
    "timing, bare loop": lambda folder: [*BASELINE.command(folder, Block(1, 1)), "--help"],
    "timing, session": lambda folder: [*SAR_TUI.command(folder, Block(1, 1)), "--help"],
}


@pytest.fixture
def hostile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with files that replace libraries where Python imports from it. They
    leave ``ran``.
    """
    folder = tmp_path / "hostile"
    folder.mkdir()
    for name in HOSTILE:
        (folder / f"{name}.py").write_text(f"open({str(folder / 'ran')!r}, 'a').write({name!r})\n")
    monkeypatch.chdir(folder)
    monkeypatch.delenv("PYTHONSAFEPATH", raising=False)
    return folder


def run(command: Sequence[str]) -> None:
    subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=60, check=False)


def test_the_files_would_run_without_the_safe_path(hostile: Path) -> None:
    run([sys.executable, "-m", "sar_tui.timing.baseline"])
    assert (hostile / "ran").exists()


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_child_program_imports_nothing_from_the_current_folder(
    name: str, hostile: Path, tmp_path: Path
) -> None:
    run(PROGRAMS[name](tmp_path))
    assert not (hostile / "ran").exists()


def test_what_a_task_loads_is_not_taken_from_the_current_folder(
    hostile: Path, catalogue: Catalogue
) -> None:
    assert modularity.load("keyboard", catalogue).package
    assert not (hostile / "ran").exists()


def test_every_child_that_runs_python_is_made_by_one_function() -> None:
    package = Path(sar_tui.__file__).parent
    users = [
        path
        for path in package.rglob("*.py")
        if re.search(r"[\[(]sys\.executable", path.read_text())
    ]
    assert [path.relative_to(package).as_posix() for path in users] == ["drivers/child_process.py"]

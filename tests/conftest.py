"""Set-up of all tests: a temporary home folder, seeded properties, the bundled tasks and themes."""

import gc
import os
import shutil
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from benchmarks.lsl_here import ON_THIS_MACHINE
from sar_tui.cli.common import Home
from sar_tui.cli.doctor.data_in_git import examine_data_in_git
from sar_tui.cli.doctor.finding import Machine
from sar_tui.loop.task import Task
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS
from sar_tui.outputs.sound.protocol import Examined
from sar_tui.plugins import Catalogue
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.validation.simulated_sessions import SessionRunner, Simulated
from tests.caches import _caches
from tests.examples import load_profile
from tests.program import call, simulated
from tests.signals import let_programs_heed_signals

__all__ = ["_caches", "call", "simulated"]

load_profile()

_HOME = pytest.StashKey[tempfile.TemporaryDirectory[str]]()


_MEMORY = Path("/dev/shm")
_ENOUGH = 2**30
_GARBAGE = 200_000
"""New objects until the next collection."""


def pytest_configure(config: pytest.Config) -> None:
    """Keep the tests away from the tasks, themes and data of the user who runs them, and from a
    slow disk.
    """
    gc.set_threshold(_GARBAGE, 20, 20)  # for the collection of tests, too
    if "TMPDIR" not in os.environ and _has_room(_MEMORY):
        # Every trial is synced to the disk: in memory the tests take half the time.
        os.environ["TMPDIR"] = tempfile.tempdir = str(_MEMORY)
    # Without bytecode on the disk, each program that a test starts would compile all its modules.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    sys.dont_write_bytecode = False
    os.environ["LC_ALL"] = "C.UTF-8"  # screens are in English, whatever the computer's language is
    os.environ.pop("PYTHONUNBUFFERED", None)  # programs end otherwise: nothing is left to write
    home = tempfile.TemporaryDirectory(prefix="sar-tui-home-")
    config.stash[_HOME] = home
    os.environ["HOME"] = home.name
    os.environ["XDG_CONFIG_HOME"] = f"{home.name}/config"
    os.environ["XDG_DATA_HOME"] = f"{home.name}/share"
    os.environ["LSLAPICFG"] = f"{home.name}/lsl_api.cfg"
    Path(os.environ["LSLAPICFG"]).write_text(ON_THIS_MACHINE, encoding="utf-8")
    os.environ["SAR_TUI_DATA"] = f"{home.name}/data"


def pytest_collection_finish() -> None:
    """Prepare the process that runs the tests.

    What was loaded is excluded from garbage collection, which is less frequent: it is a fifth of
    the time otherwise.
    """
    let_programs_heed_signals()
    gc.collect()
    gc.freeze()


def _has_room(folder: Path) -> bool:
    return os.access(folder, os.W_OK) and shutil.disk_usage(folder).free > _ENOUGH


def pytest_unconfigure(config: pytest.Config) -> None:
    config.stash[_HOME].cleanup()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say in one line each what was not tested, and what is missing for it."""
    skipped = terminalreporter.stats.get("skipped", [])
    reasons = Counter(report.longrepr[2].removeprefix("Skipped: ") for report in skipped)
    for reason, number in reasons.items():
        tests = "1 test was" if number == 1 else f"{number} tests were"
        terminalreporter.write_line(f"{tests} not run: {reason}", yellow=True)
    found = examine_data_in_git(Machine(Home(Path(__file__).parents[1] / "data"), Examined))
    if found.state != "ok":
        terminalreporter.write_line(f"! {found.found}. {found.advice}", yellow=True)


@pytest.fixture(scope="session")
def catalogue() -> Catalogue:
    return Catalogue()


@pytest.fixture(scope="session")
def keyboard(catalogue: Catalogue) -> type[Task]:
    return catalogue.task("keyboard")


@pytest.fixture(scope="session")
def calm(catalogue: Catalogue) -> Theme:
    return catalogue.theme("calm")


@pytest.fixture(scope="session")
def _simulated() -> dict[object, Simulated]:
    return {}


@pytest.fixture
def simulated_once(_simulated: dict[object, Simulated], monkeypatch: pytest.MonkeyPatch) -> None:
    """Let validations share their sessions: the same user, seed and parameters are simulated
    once.
    """
    run = SessionRunner.run

    def recall(runner: SessionRunner, user: str, seed: int, **parameters: object) -> Simulated:
        key = (repr(PEOPLE[user]), seed, repr(sorted(parameters.items())))
        if key not in _simulated:
            _simulated[key] = run(runner, user, seed, **parameters)
        return _simulated[key]

    monkeypatch.setattr(SessionRunner, "run", recall)


@pytest.fixture
def fewer_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Send samples of simulated hands in larger blocks, which is faster and does not change the
    results.
    """
    monkeypatch.setattr("sar_tui.inputs.simulated.STEP", 40 * MS)
    monkeypatch.setattr("sar_tui.inputs.sensor.DRAIN", 40 * MS)


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """A data folder that does not exist yet."""
    return tmp_path / "data"


@pytest.fixture(scope="session")
def stats() -> Any:
    """``scipy.stats``, the judge of statistics: imported only by a process that needs it, as it
    takes a second.
    """
    from scipy import stats

    return stats

"""What every test has: no settings of the user's own, seeded properties, the shipped task and themes."""

import os
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from sar_tui.framework.task import Task
from sar_tui.framework.theme import Theme
from sar_tui.plugins import Catalogue
from tests.program import call, simulated

__all__ = ["call", "simulated"]

settings.register_profile(
    "seeded",
    derandomize=True,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
settings.load_profile("seeded")


_HOME = pytest.StashKey[tempfile.TemporaryDirectory[str]]()


def pytest_configure(config: pytest.Config) -> None:
    """No test sees, or touches, the tasks, themes and data of whoever runs it."""
    config.stash[_HOME] = home = tempfile.TemporaryDirectory(prefix="sar-tui-home-")
    os.environ["HOME"] = home.name
    os.environ["XDG_CONFIG_HOME"] = f"{home.name}/config"
    os.environ["XDG_DATA_HOME"] = f"{home.name}/share"
    os.environ["SAR_TUI_DATA"] = f"{home.name}/data"


def pytest_unconfigure(config: pytest.Config) -> None:
    config.stash[_HOME].cleanup()


@pytest.fixture(scope="session")
def catalogue() -> Catalogue:
    return Catalogue()


@pytest.fixture(scope="session")
def keyboard(catalogue: Catalogue) -> type[Task]:
    return catalogue.task("keyboard")


@pytest.fixture(scope="session")
def calm(catalogue: Catalogue) -> Theme:
    return catalogue.theme("calm")


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """A data folder that does not exist yet."""
    return tmp_path / "data"

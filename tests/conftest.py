"""What every test has: no settings of the user's own, seeded properties, the shipped task and themes."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from sar_tui.framework.task import Task
from sar_tui.framework.theme import Theme
from sar_tui.plugins import Catalogue

settings.register_profile(
    "seeded",
    derandomize=True,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
settings.load_profile("seeded")


@pytest.fixture(scope="session", autouse=True)
def a_home_of_its_own(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """No test sees, or touches, the tasks, themes and data of whoever runs it."""
    home = tmp_path_factory.mktemp("home")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HOME", str(home))
        patch.setenv("XDG_CONFIG_HOME", str(home / "config"))
        patch.setenv("XDG_DATA_HOME", str(home / "share"))
        patch.setenv("SAR_TUI_DATA", str(home / "data"))
        yield


@pytest.fixture(scope="session")
def catalogue(a_home_of_its_own: None) -> Catalogue:
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

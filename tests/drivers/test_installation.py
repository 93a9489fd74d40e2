"""Hints that say how to install what is missing name what works."""

import re
import sys
from pathlib import Path

import pytest

from sar_tui.drivers import installation
from sar_tui.drivers.installation import pip_install, pip_install_extra

REPOSITORY = Path(__file__).parents[2]


@pytest.fixture
def elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    """The program as it is when it was installed from a wheel."""
    monkeypatch.setattr(installation, "checkout", lambda: None)


def test_in_a_checkout_an_extra_is_one_of_the_checkout(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "prefix", str(REPOSITORY / ".venv"))
    pip = r".venv\Scripts\pip" if sys.platform == "win32" else ".venv/bin/pip"
    assert pip_install_extra("serve") == f"{pip} install -e '.[serve]'"
    monkeypatch.setattr(sys, "prefix", "/another")
    assert pip_install_extra("serve") == "pip install -e '.[serve]'"
    assert pip_install("phidget22", "libusb-package") == "pip install phidget22 libusb-package"


@pytest.mark.usefixtures("elsewhere")
def test_an_installed_program_names_the_packages_of_an_extra() -> None:
    assert re.fullmatch(r"pip install 'pylsl[<>=,.0-9]+'", pip_install_extra("lsl"))
    assert re.fullmatch(
        r"pip install 'cryptography[^ ]+' 'eclipse-zenoh[^ ]+'", pip_install_extra("link")
    )
    for extra in ("ros", "images", "serve", "report", "export", "lake", "serial"):
        assert "'" in pip_install_extra(extra), "it has a package, with its versions"


def test_no_text_installs_a_package_of_the_programs_name_from_the_index() -> None:
    folders = [REPOSITORY / name for name in ("sar_tui", "tasks", "themes", "docs", "benchmarks")]
    texts = [
        path
        for folder in folders
        for path in folder.rglob("*")
        if path.suffix in (".py", ".md", ".toml", ".js")
    ]
    for path in (*texts, *REPOSITORY.glob("*.md")):
        found = re.search(r"sar-tui\[|pip install sar-tui", path.read_text(encoding="utf-8"))
        assert not found, f"{path}: {found}"

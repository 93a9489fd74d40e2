"""The installation that runs: the checkout, if it runs from one, and the commands that add packages
to it.
"""

import os
import re
import shlex
import sys
from functools import cache
from pathlib import Path

_NAME = "sar-tui"


@cache
def checkout() -> Path | None:
    """Return the folder of the checkout that the program runs from; None if it is installed
    elsewhere.
    """
    folder = Path(__file__).resolve().parents[2]
    return folder if (folder / "pyproject.toml").exists() else None


def pip_install(*packages: str) -> str:
    """Return the command that installs packages from the index into the environment of the
    program.
    """
    return f"{_pip()} install {' '.join(map(shlex.quote, packages))}"


def pip_install_extra(extra: str) -> str:
    """Return the command that installs an extra: in a checkout, or else by the names of its
    packages.

    An extra is never asked for by the name of the program: on the public index that is not ours.
    """
    if checkout():
        return f"{_pip()} install -e '.[{extra}]'"
    return pip_install(*_packages(extra))


def _pip() -> str:
    """Return the pip of the program's environment, as it is called in the checkout or after
    activation.
    """
    folder = checkout()
    if folder and Path(sys.prefix).resolve() == folder / ".venv":
        return r".venv\Scripts\pip" if os.name == "nt" else ".venv/bin/pip"
    return "pip"


def _packages(extra: str) -> list[str]:
    """Return the packages of an extra, with the versions that the program works with."""
    from importlib.metadata import requires

    wanted = re.compile(rf"extra\s*==\s*['\"]{re.escape(extra)}['\"]")
    return [line.partition(";")[0].strip() for line in requires(_NAME) or () if wanted.search(line)]

"""People's data that git tracks or would take: in the data folder, and in the checkout of the
program.
"""

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import sar_tui
from sar_tui.cli.doctor.finding import Finding, Machine, care, ok

_LISTED = 3
_SAMPLE = ("README.md", "make_recording.py", "table-4.1.csv")
"""Files in ``data`` of a checkout that belong to the program."""
_OF_PEOPLE = (
    "*.db",
    "*.db-wal",
    "*.db-shm",
    "*.sar-link",
    "*.key",
    "passphrase.json",
    "passphrase.log",
)
"""Names of databases, invitations and keys, which the program has none of."""


class DataInGit(NamedTuple):
    """Files of people, relative to the checkout where they are in it: those git tracks, those ``git
    add .`` takes.
    """

    tracked: tuple[Path, ...] = ()
    would_add: tuple[Path, ...] = ()


def examine_data_in_git(here: Machine) -> Finding:
    """Check that git neither tracks people's data nor would add it."""
    found = data_in_git(checkout(), here.home.folder)
    if not (found.tracked or found.would_add):
        return ok("git neither tracks data of people here, nor would add it")
    said = [
        f"git {does} {_listed(paths)}"
        for does, paths in (("tracks", found.tracked), ("would add", found.would_add))
        if paths
    ]
    advice = "Add them to .gitignore."
    if found.tracked:
        advice = (
            "Do not push: whoever gets the repository gets the data. `git rm --cached FILE` keeps "
            "a file and takes it "
            "out of the next commit; earlier commits still hold it."
        )
    return care(f"{', and '.join(said)}: data of people", advice)


def _listed(paths: Sequence[Path]) -> str:
    more = len(paths) - _LISTED
    return ", ".join(map(str, paths[:_LISTED])) + (f" and {more} more" if more > 0 else "")


def checkout() -> Path | None:
    """Return the folder of the checkout that the program runs from; None if it is installed
    elsewhere.
    """
    folder = Path(sar_tui.__file__).parents[1]
    return folder if (folder / ".git").exists() else None


def data_in_git(checkout: Path | None, data: Path | None) -> DataInGit:
    """Return the files of people that git knows in a checkout, and in a data folder, wherever that
    is.
    """
    from sar_tui.drivers.git import tracked, would_add

    found = []
    for list_files in (tracked, would_add):
        in_checkout = (
            [path for path in list_files(checkout) if _is_of_people(path, checkout)]
            if checkout
            else []
        )
        in_data = list_files(data.resolve()) if data is not None and data.is_dir() else []
        both = (*in_checkout, *(path for path in in_data if path.name not in _SAMPLE))
        found.append(tuple(sorted({_named(path, checkout) for path in both})))
    return DataInGit(*found)


def _is_of_people(path: Path, checkout: Path) -> bool:
    from sar_tui.export.recoding import EARLIER_HEAD, HEAD
    from sar_tui.export.target import MANIFEST

    if path.parent == checkout / "data":
        return path.name not in _SAMPLE
    if (
        checkout / "data" in path.parents
        or path.name == MANIFEST
        or any(map(path.match, _OF_PEOPLE))
    ):
        return True
    return path.suffix == ".csv" and _head(path) in (HEAD, EARLIER_HEAD)


def _head(path: Path) -> tuple[str, ...]:
    try:
        with path.open(encoding="utf-8", newline="") as file:
            return tuple(next(csv.reader(file), ()))
    except (OSError, ValueError, csv.Error):
        return ()


def _named(path: Path, checkout: Path | None) -> Path:
    """Return a path relative to the checkout, if it is in it."""
    return path.relative_to(checkout) if checkout and path.is_relative_to(checkout) else path

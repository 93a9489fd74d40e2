"""Folders that only this user can open."""

from pathlib import Path


def make_private(folder: Path) -> None:
    """Create a folder and those above it that are missing, all with mode 0700, whatever the umask.

    ``Path.mkdir`` gives the mode to the last one only.
    """
    missing = []
    while not folder.exists():
        missing.append(folder)
        folder = folder.parent
    for each in reversed(missing):
        each.mkdir(mode=0o700, exist_ok=True)

"""Files and folders: for their owner only, and never in the place of another."""

import os
import secrets
from pathlib import Path


def unused(path: Path) -> Path:
    """Return the path, or one with a number if there is a file or folder of that name:
    ``copy-2.db``.
    """
    free, number = path, 1
    while os.path.lexists(free):
        number += 1
        free = path.with_name(f"{path.stem}-{number}{path.suffix}")
    return free


def write_private(path: Path, content: str | bytes) -> None:
    """Write a text in UTF-8, or bytes, into a new file with mode 0600.

    Raises:
        FileExistsError: there is such a file.
        OSError: it cannot be written, and is not there then.
    """
    number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    try:
        with open(number, "wb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
    except BaseException:
        path.unlink(missing_ok=True)
        raise


def replace_private(path: Path, content: str | bytes) -> None:
    """Put a new file with mode 0600 in the place of one, on the disk, whole or not at all. Raises
    OSError.
    """
    new = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        write_private(new, content)
        sync_file(new)
        os.replace(new, path)
    finally:
        new.unlink(missing_ok=True)
    sync_folder(path.parent)


def sync_file(path: Path) -> None:
    """Bring a file to the disk. Raises OSError."""
    with path.open("rb+") as file:
        os.fsync(file.fileno())


def sync_folder(folder: Path) -> None:
    """Bring the names in a folder to the disk, where the system can do that. Raises OSError."""
    if os.name == "posix":
        number = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(number)
        finally:
            os.close(number)


def append_private(path: Path, text: str) -> None:
    """Append a text in UTF-8 to a file, which gets mode 0600 if it is new. Raises OSError."""
    number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
    with open(number, "a", encoding="utf-8") as file:
        file.write(text)


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

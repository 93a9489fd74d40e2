"""File locks of sessions and participants. The system releases them when the program ends, even
after a crash.
"""

import os
from pathlib import Path
from typing import TYPE_CHECKING

from sar_tui.drivers.files import make_private
from sar_tui.model.language import Sentence
from sar_tui.store.database import UNWRITABLE, StoreError

if TYPE_CHECKING:  # loaded with the first lock: lists of sessions rarely need one
    import filelock

_TIMEOUT_SECONDS = 0.5
"""Longest wait for a lock that is taken: another program's ``is_held`` takes it for a moment."""
_IN_USE = "{name} is in use already, in another window or program."
_HELD = {
    "session": "The session {name} is in a live session already, in another window or program.",
    "participant": "The participant {name} is in a live session already, in another window or "
    "program.",
}


class Held(StoreError):
    """Another program holds the lock."""


def _path(folder: Path, kind: str, name: str) -> Path:
    locks = folder / "locks"
    make_private(locks)
    return locks / f"{kind}-{name}.lock"


def hold(folder: Path, kind: str, name: str) -> "filelock.BaseFileLock":
    """Take the lock of a session or a participant until it is released, or this program ends.

    Raises:
        Held: another program holds it.
        StoreError: the folder cannot be written to.
    """
    import filelock

    try:
        lock = filelock.FileLock(_path(folder, kind, name), mode=0o600)
        lock.acquire(timeout=_TIMEOUT_SECONDS)
    except filelock.Timeout:
        raise Held(Sentence(_HELD.get(kind, _IN_USE), name=name)) from None
    except OSError as error:
        raise StoreError(
            Sentence(UNWRITABLE, folder=str(folder), why=os.strerror(error.errno or 0))
        ) from error
    return lock


def is_held(folder: Path, kind: str, name: str) -> bool:
    """Return True if a program holds the lock now; False where nothing can be written, and so
    nothing runs.
    """
    try:
        path = _path(folder, kind, name)
        if not path.exists():
            return False
    except OSError:
        return False
    import filelock

    try:
        lock = filelock.FileLock(path, mode=0o600)
        lock.acquire(blocking=False)
    except filelock.Timeout:
        return True
    except OSError:
        return False
    lock.release()
    return False

"""The folder of an export, complete or absent, with its manifest."""

import contextlib
import errno
import hashlib
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from glob import escape
from pathlib import Path
from typing import Any

import filelock
import msgspec

from sar_tui import __version__
from sar_tui.drivers.files import make_private, sync_file, sync_folder
from sar_tui.export.errors import ExportError

MANIFEST = "sar-tui-export.json"
"""The file in an export that says what it holds, and by which a later export knows its own
folder.
"""
LOCK = ".sar-tui-lock"
"""Held in the hidden folder while it is written, so that one that was left behind is recognised."""
_NO_TIME_NS = 946_684_800 * 10**9
"""The beginning of the year 2000, which every zip archive can hold."""
_BEFORE = "-before"
"""Ending of the hidden name under which an earlier export waits for a moment while the new one
takes its place.
"""


class _Manifest(msgspec.Struct):
    """The parts of a manifest that say if its folder may be replaced."""

    format: str
    files: list["_File"]


class _File(msgspec.Struct):
    path: str


@contextmanager
def target(folder: Path, format: str) -> Iterator[Path]:
    """Give a hidden folder beside the target to write into; it takes the target's place when the
    block is over.

    The block calls `sync` when all files are written.

    If the block raises, or the program is killed, the target is as it was. What a killed program
    left is removed by the next export to the same target.

    Raises:
        ExportError: the target cannot be made, is a file or a disk, or holds other files than those
            of an export in this format.
    """
    folder = folder.resolve()
    _remove_left_behind(folder)
    check(folder, format)
    with made_beside(folder):
        hidden = Path(tempfile.mkdtemp(prefix=_prefix(folder), dir=folder.parent))
    lock = filelock.FileLock(hidden / LOCK, mode=0o600)
    try:
        lock.acquire(blocking=False)
        yield hidden
        check(folder, format)  # again: somebody may have put files there meanwhile
        lock.release()
        (hidden / LOCK).unlink(missing_ok=True)
        _put_in_place(hidden, folder)
    except BaseException:
        lock.release()
        shutil.rmtree(hidden, ignore_errors=True)
        raise


def check(folder: Path, format: str) -> None:
    """Raise ExportError unless a folder is absent, empty, or holds an export in this format and
    nothing else.
    """
    if not folder.exists():
        return
    if not folder.is_dir():
        raise ExportError(
            f"{folder} is a file. Name a folder that does not exist yet, or is empty.",
            bad_input=True,
        )
    if folder.is_mount():
        raise ExportError(
            f"{folder} is a whole disk. Name a folder on it: {folder / 'export'}", bad_input=True
        )
    if folder == Path.cwd():
        raise ExportError(
            f"{folder} is the folder you are in. Name another one: --to export", bad_input=True
        )
    present = {
        path.relative_to(folder).as_posix() for path in folder.rglob("*") if not path.is_dir()
    }
    if not present:
        return
    made = _manifest(folder / MANIFEST)
    if made is None:
        raise ExportError(
            f"{folder} holds other files, and an export never mixes with them. Name a folder that "
            "is empty, or does "
            "not exist yet.",
            bad_input=True,
        )
    if made.format != format:
        raise ExportError(
            f"{folder} holds an export in the format {made.format}. Name another folder for "
            f"{format}.",
            bad_input=True,
        )
    if others := sorted(present - {file.path for file in made.files} - {MANIFEST}):
        raise ExportError(
            f"{folder} holds an earlier export, and files that are not of it, such as "
            f"{others[0]}. Move them, or name "
            "another folder.",
            bad_input=True,
        )


def _manifest(path: Path) -> _Manifest | None:
    try:
        return msgspec.json.decode(path.read_bytes(), type=_Manifest)
    except (OSError, msgspec.MsgspecError):
        return None


def _prefix(folder: Path) -> str:
    return f".{folder.name}.sar-tui-"


def sync(folder: Path) -> None:
    """Make everything in a folder private, and write it to the disk."""
    for path in [*folder.rglob("*"), folder]:
        path.chmod(0o700 if path.is_dir() else 0o600)
        if path.is_file():
            sync_file(path)
        else:
            sync_folder(path)


def forget_times(folder: Path, *, files: bool = True) -> None:
    """Give everything in a folder, and the folder, the same time of change: the order of files
    would tell an order.

    Args:
        files: false for folders only.
    """
    for path in [*folder.rglob("*"), folder]:
        if files or path.is_dir():
            # a folder of another site may be of another login
            with contextlib.suppress(PermissionError):
                os.utime(path, ns=(_NO_TIME_NS, _NO_TIME_NS))


def _put_in_place(hidden: Path, folder: Path) -> None:
    before = None
    if folder.exists():
        before = hidden.with_name(f"{hidden.name}{_BEFORE}")
        folder.rename(before)
    try:
        hidden.rename(folder)
    except BaseException:
        if before is not None:
            before.rename(folder)
        raise
    sync_folder(folder.parent)
    if before is not None:
        shutil.rmtree(before, ignore_errors=True)


def _remove_left_behind(folder: Path) -> None:
    """Remove hidden folders that a killed export left; put back the earlier export if it was just
    being replaced.
    """
    for path in (
        sorted(folder.parent.glob(f"{escape(_prefix(folder))}*")) if folder.parent.is_dir() else ()
    ):
        if path.name.endswith(_BEFORE):
            if not folder.exists():
                with contextlib.suppress(OSError):
                    path.rename(folder)
            shutil.rmtree(path, ignore_errors=True)
        elif not is_locked(path):
            shutil.rmtree(path, ignore_errors=True)


def is_locked(path: Path) -> bool:
    lock = filelock.FileLock(path / LOCK, mode=0o600)
    try:
        lock.acquire(blocking=False)
    except (filelock.Timeout, OSError):
        return True
    lock.release()
    return False


_BLOCK = 1 << 20


def write_manifest(folder: Path, about: Path = Path(), **facts: Any) -> str:
    """Write the manifest of a folder whose files are complete; return its SHA-256.

    Args:
        about: the place of the manifest in the folder.
        facts: the format, the sessions, and other facts about the export.
    """
    files = [
        {
            "path": path.relative_to(folder).as_posix(),
            "bytes": path.stat().st_size,
            "sha256": sha256(path),
        }
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != LOCK
    ]
    manifest = (
        msgspec.json.format(msgspec.json.encode({"sar_tui": __version__, **facts, "files": files}))
        + b"\n"
    )
    (folder / about / MANIFEST).write_bytes(manifest)
    return hashlib.sha256(manifest).hexdigest()


def sha256(path: Path) -> str:
    """Return the SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


_FULL = (errno.ENOSPC, errno.EDQUOT)


@contextmanager
def made_beside(path: Path) -> Iterator[None]:
    """Make the folder that a path is in, and run a block that makes hidden files there.

    Raises:
        ExportError: the folder cannot be made or written to.
        OSError: the disk is full.
    """
    above = next(folder for folder in path.absolute().parents if folder.exists())
    if not above.is_dir():
        raise ExportError(f"{path} cannot be made: {above} is a file.", bad_input=True)
    try:
        make_private(path.absolute().parent)
        yield
    except OSError as error:
        if error.errno in _FULL:
            raise
        if error.errno == errno.ENAMETOOLONG:
            raise ExportError(
                f"{path} is too long for the name of a file or folder.", bad_input=True
            ) from error
        raise ExportError(f"{path} cannot be made: {error.strerror or error}.") from error

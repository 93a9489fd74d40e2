"""The letterbox: a folder that programs beyond our control copy to and from other computers.

A file in it may be half-written, doubled, or of anybody. Its name is random, and says nothing.
"""

import contextlib
import os
import secrets
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from sar_tui.drivers.files import sync_file, sync_folder, write_private
from sar_tui.letterbox.sealing import LARGEST_FILE, Damaged
from sar_tui.model.language import Sentence
from sar_tui.store.database import StoreError

LETTER, INVITATION = ".letter", ".invitation"
"""Endings of the files' names."""
README = "READ ME.txt"
_UNFINISHED = ".unfinished"
_README = """\
This folder is a letterbox of sar-tui, a program for motor rehabilitation.

The files are sealed letters between a clinic and the homes of people who train. Nobody else can
open them. Do not rename, change or delete them: the program removes what has arrived.
"""
_LONGEST_NAME = 200


class LetterFile(NamedTuple):
    """A file in the letterbox: its name, size in bytes, and when it was written last."""

    name: str
    size: int
    changed_ns: int


class Letterbox:
    """A letterbox on this computer.

    Args:
        path: the folder.

    Raises:
        StoreError: it is not there, is no letterbox, or cannot be read and written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            names = os.listdir(path)
        except OSError as error:
            raise _gone(path, error) from error
        if README not in names and not any(LETTER in name for name in names):
            raise StoreError(
                Sentence(
                    "{folder} is no letterbox, or is not synchronised yet. If it is a new one: "
                    "sar-tui letterbox new.",
                    folder=str(path),
                ),
                bad_input=True,
            )
        if not os.access(path, os.W_OK | os.X_OK):
            raise StoreError(
                Sentence(
                    "{folder} belongs to another user: this one may not write there. Allow it, or "
                    "use another folder.",
                    folder=str(path),
                ),
                bad_input=True,
            )

    def files(self) -> Iterator[LetterFile]:
        """Yield what may be letters: also copies that a synchronisation program renamed."""
        try:
            with os.scandir(self.path) as entries:
                found = [
                    entry
                    for entry in entries
                    if LETTER in entry.name
                    and not entry.name.startswith(".")
                    and _UNFINISHED not in entry.name
                    and len(entry.name) <= _LONGEST_NAME
                    and entry.name.isprintable()
                ]
        except OSError as error:
            raise _gone(self.path, error) from error
        for entry in sorted(found, key=lambda one: one.name):
            with contextlib.suppress(OSError):  # it was removed meanwhile
                if entry.is_file(follow_symlinks=False):
                    facts = entry.stat(follow_symlinks=False)
                    yield LetterFile(entry.name, facts.st_size, facts.st_mtime_ns)

    def read(self, file: LetterFile) -> bytes | None:
        """Return the bytes of a file; None if it is gone.

        Raises:
            Damaged: it is too large for a letter.
            StoreError: it cannot be read.
        """
        if file.size > LARGEST_FILE:
            raise Damaged
        try:
            with open(self.path / file.name, "rb") as opened:
                return opened.read(LARGEST_FILE + 1)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise StoreError(
                Sentence(
                    "{file} in the letterbox cannot be read ({why}). Does it belong to another user?",
                    file=file.name,
                    why=error.strerror,
                ),
                temporary=True,
            ) from error

    def has(self, name: str, size: int) -> bool:
        """Return True if there is a file of a name and size."""
        try:
            return (self.path / name).stat().st_size == size
        except OSError:
            return False

    def put(self, name: str, sealed: bytes) -> None:
        """Write a file, complete under its name or not at all. Raises StoreError."""
        unfinished = self.path / f".{name}{_UNFINISHED}"
        try:
            unfinished.unlink(missing_ok=True)
            try:
                write_private(unfinished, sealed)
                sync_file(unfinished)
                os.replace(unfinished, self.path / name)
                with contextlib.suppress(OSError):  # some mounts cannot
                    sync_folder(self.path)
            finally:
                unfinished.unlink(missing_ok=True)
        except OSError as error:
            raise _gone(self.path, error) from error

    def remove(self, name: str) -> None:
        """Remove a file; if that cannot be done, it stays."""
        with contextlib.suppress(OSError):
            (self.path / name).unlink()

    def remove_unfinished(self, before: float) -> None:
        """Remove what programs that ended have left half-written; not what another computer writes
        now. ``before``: Unix time in seconds.
        """
        for path in self.path.glob(f".*{_UNFINISHED}"):
            with contextlib.suppress(OSError):
                if path.stat().st_mtime < before:
                    path.unlink()


def new_name(ending: str = LETTER) -> str:
    """Return a random name of a file."""
    return secrets.token_hex(16) + ending


def make(path: Path, data: Path) -> None:
    """Make a folder a letterbox.

    Raises:
        StoreError: it lies in the data folder, or the other way round, holds other things, or
            cannot be written.
    """
    check_apart(path, data)
    try:
        path.mkdir(parents=True, exist_ok=True)
        names = [name for name in os.listdir(path) if not name.startswith(".")]
        others = [name for name in names if name != README and LETTER not in name]
        others = [name for name in others if not name.endswith(INVITATION)]
        if others:
            raise StoreError(
                f"{path} holds other files, such as {others[0][:40]}. A letterbox is a folder of "
                "its own.",
                bad_input=True,
            )
        if README not in names:
            (path / README).write_text(_README)
    except OSError as error:
        raise _gone(path, error) from error


def check_apart(path: Path, data: Path) -> None:
    """Raise StoreError if a letterbox and the data folder are one, or one is in the other."""
    box, own = path.absolute().resolve(), data.absolute().resolve()
    if box.is_relative_to(own) or own.is_relative_to(box):
        raise StoreError(
            Sentence(
                "The letterbox cannot be in the data folder {data}, nor around it: what is there "
                "is not sealed. Choose another folder.",
                data=str(data),
            ),
            bad_input=True,
        )


def _gone(path: Path, error: OSError) -> StoreError:
    return StoreError(
        Sentence(
            "The letterbox {folder} cannot be used ({why}). Letters wait until it can.",
            folder=str(path),
            why=error.strerror or str(error),
        ),
        temporary=True,
    )

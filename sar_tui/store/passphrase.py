"""The therapist's passphrase of a data folder: a salted scrypt hash in a file, and a log of the
tries.

It guards screens. Whoever can write to the data folder can replace it.
"""

import contextlib
import hashlib
import hmac
import os
import secrets
import time
import unicodedata
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Literal

import msgspec

from sar_tui.drivers.files import make_private, replace_private
from sar_tui.model.language import Sentence
from sar_tui.store.database import StoreError

FILE = "passphrase.json"
LOG = "passphrase.log"
SHORTEST = 6
"""Characters that a passphrase has at least."""
FREE_TRIES = 3
"""Wrong passphrases in a row before the first wait."""
FIRST_WAIT_S = 5.0
LONGEST_WAIT_S = 300.0
_LOG_TAIL = 65_536
"""Bytes of the log that are read: more tries than the longest wait needs."""
_COST, _BLOCK, _PARALLEL = 2**15, 8, 1  # 32 MB and about 0.1 s


class _Hash(msgspec.Struct, frozen=True):
    """A stored passphrase. The bounds keep a damaged file from asking for all the memory."""

    salt: bytes
    key: bytes
    cost: Annotated[int, msgspec.Meta(ge=2, le=2**18)] = _COST
    block: Annotated[int, msgspec.Meta(ge=1, le=16)] = _BLOCK
    parallel: Annotated[int, msgspec.Meta(ge=1, le=4)] = _PARALLEL

    def matches(self, text: str) -> bool:
        """Return True if this is the passphrase."""
        return hmac.compare_digest(self.key, _derive(text, self))


class Try(msgspec.Struct, frozen=True):
    """A passphrase that was entered: when (UTC, ISO 8601), the result, and on which screen."""

    at: str
    result: Literal["right", "wrong"]
    where: str = ""

    @property
    def seconds(self) -> float:
        """When, in seconds of Unix time; 0 if that cannot be read."""
        with contextlib.suppress(ValueError, OverflowError):
            return datetime.fromisoformat(self.at).timestamp()
        return 0.0


class Passphrase:
    """The passphrase of a data folder.

    After `FREE_TRIES` wrong ones in a row, each further one is followed by a wait, twice as long
    each time. The count is in the log, so that a restart does not shorten the wait.

    Args:
        folder: the data folder.
        now: Unix time in seconds.
    """

    def __init__(self, folder: Path, now: Callable[[], float] = time.time) -> None:
        self._folder = folder
        self._now = now
        self._kept: _Hash | None = None
        self._wrong_here, self._last_wrong_here = 0, 0.0

    @property
    def is_set(self) -> bool:
        """True if a passphrase guards the therapist's screens; also if its file cannot be read."""
        return self._kept is not None or self._path.exists()

    def keep(self) -> None:
        """Go on with the present passphrase even if its file is removed. Raises StoreError."""
        self._kept = self._read()

    def release(self) -> None:
        """Follow the file again."""
        self._kept = None

    def set(self, text: str) -> None:
        """Set the passphrase. Raises StoreError if it is too short, or cannot be written."""
        if len(_normal(text)) < SHORTEST:
            raise StoreError(
                Sentence("A passphrase has at least {count} characters.", count=SHORTEST),
                bad_input=True,
            )
        salt = secrets.token_bytes(16)
        stored = _Hash(salt, b"", _COST)
        content = msgspec.json.encode(msgspec.structs.replace(stored, key=_derive(text, stored)))
        try:
            make_private(self._folder)
            replace_private(self._path, content)
        except OSError as error:
            raise StoreError(
                Sentence(
                    "The passphrase cannot be stored in {folder} ({why}).",
                    folder=str(self._folder),
                    why=error.strerror,
                )
            ) from error

    def remove(self) -> None:
        """Remove the passphrase. Raises StoreError."""
        try:
            self._path.unlink(missing_ok=True)
        except OSError as error:
            raise StoreError(f"{self._path} cannot be removed ({error.strerror}).") from error

    @property
    def wait_s(self) -> float:
        """Seconds until the next passphrase can be tried; 0 if it can now."""
        tries = self.tries()
        wrong = _wrong_in_a_row(tries)
        last = tries[-1].seconds if wrong else 0.0
        if self._wrong_here > wrong:  # the log cannot be written
            wrong, last = self._wrong_here, self._last_wrong_here
        if wrong < FREE_TRIES:
            return 0.0
        wait = min(LONGEST_WAIT_S, FIRST_WAIT_S * 2.0 ** min(wrong - FREE_TRIES, 30))
        passed = self._now() - last
        # the clock was set back: nobody can wait for that
        return max(0.0, wait - passed) if passed >= 0 else 0.0

    def check(self, text: str, where: str = "") -> bool:
        """Return True if this is the passphrase, and log the try. While one has to wait, it is
        never right.

        Raises:
            StoreError: the stored passphrase cannot be read.
        """
        stored = self._stored()
        if self.wait_s > 0:
            return False
        is_right = stored.matches(text)
        if is_right:
            self._wrong_here = 0
        else:
            self._wrong_here, self._last_wrong_here = self._wrong_here + 1, self._now()
        at = datetime.fromtimestamp(self._now(), UTC).isoformat(timespec="seconds")
        line = msgspec.json.encode(Try(at, "right" if is_right else "wrong", where)) + b"\n"
        with contextlib.suppress(OSError):  # a full disk must not lock the therapist out
            _write(self._folder / LOG, os.O_CREAT | os.O_APPEND, line)
        return is_right

    def tries(self) -> list[Try]:
        """Return the latest tries, the last one last."""
        try:
            with (self._folder / LOG).open("rb") as log:
                log.seek(max(0, log.seek(0, os.SEEK_END) - _LOG_TAIL))
                lines = log.read().splitlines()
        except OSError:
            return []
        found = []
        for line in lines:
            with contextlib.suppress(msgspec.DecodeError):  # cut off by a crash, or by the tail
                found.append(msgspec.json.decode(line, type=Try))
        return found

    @property
    def _path(self) -> Path:
        return self._folder / FILE

    def _stored(self) -> _Hash:
        """Return the passphrase of the file, or the kept one if the file is gone or damaged."""
        try:
            return self._read()
        except StoreError:
            if self._kept is None:
                raise
            return self._kept

    def _read(self) -> _Hash:
        again = "Set the passphrase again: sar-tui passphrase."
        try:
            return msgspec.json.decode(self._path.read_bytes(), type=_Hash)
        except FileNotFoundError as error:
            raise StoreError(
                "There is no passphrase. Set one: sar-tui passphrase.", bad_input=True
            ) from error
        except OSError as error:
            raise StoreError(f"{self._path} cannot be read ({error.strerror}). {again}") from error
        except msgspec.DecodeError as error:
            raise StoreError(f"{self._path} is damaged. {again}") from error


def _wrong_in_a_row(tries: list[Try]) -> int:
    wrong = 0
    for each in reversed(tries):
        if each.result == "right":
            break
        wrong += 1
    return wrong


def _normal(text: str) -> str:
    """Return a passphrase as it is hashed: the same however a keyboard composes its accents."""
    return unicodedata.normalize("NFKC", text)


def _derive(text: str, stored: _Hash) -> bytes:
    try:
        return hashlib.scrypt(
            _normal(text).encode("utf-8", "surrogatepass"),
            salt=stored.salt,
            n=stored.cost,
            r=stored.block,
            p=stored.parallel,
            maxmem=2 * 128 * stored.cost * stored.block * stored.parallel,
            dklen=32,
        )
    except ValueError as error:  # the file holds a cost that is not a power of two
        raise StoreError(
            "The stored passphrase cannot be used. Set it again: sar-tui passphrase."
        ) from error


def _write(path: Path, how: int, content: bytes) -> None:
    """Write to a file that only this user can read, and wait for the disk."""
    file = os.open(path, os.O_WRONLY | how, 0o600)
    try:
        os.write(file, content)
        os.fsync(file)
    finally:
        os.close(file)

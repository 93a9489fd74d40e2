"""Token that opens a served view: new each time, or stored in a file that only its owner can
read.
"""

import os
import secrets
import stat
from pathlib import Path

from sar_tui.drivers.new_file import write_private

_MIN_LENGTH = 22
"""Characters; 128 bits."""


class TokenError(ValueError):
    """A token cannot be stored or read; the message is one or two clear sentences."""


def new_token() -> str:
    """Return a new random token."""
    return secrets.token_urlsafe(32)


def load_or_create_token(path: Path) -> str:
    """Return the token in a file, which is created if it does not exist.

    Raises:
        TokenError: others can read the file, it contains no token, or it cannot be used.
    """
    try:
        with open(path, encoding="ascii") as file:
            _refuse_shared(path, os.fstat(file.fileno()))
            token = file.read(1000).strip()
    except FileNotFoundError:
        return _create(path)
    except OSError as error:
        raise TokenError(f"The token file {path} cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError:
        token = ""
    if len(token) < _MIN_LENGTH or not all(
        character.isalnum() or character in "-_" for character in token
    ):
        raise TokenError(
            f"The file {path} contains no token: {_MIN_LENGTH} or more letters, digits, - and _. "
            "Give the name of a new file to create one."
        )
    return token


def _refuse_shared(path: Path, status: os.stat_result) -> None:
    if os.name == "posix" and stat.S_IMODE(status.st_mode) & 0o077:
        raise TokenError(
            f"Other users can read the token file {path}: run chmod 600 {path}, or use another "
            "file."
        )


def _create(path: Path) -> str:
    token = new_token()
    try:
        write_private(path, f"{token}\n")
    except OSError as error:
        raise TokenError(f"The token file {path} cannot be created: {error.strerror}.") from error
    return token

"""The token that opens a served view: new each time, or kept in a file that only its owner can read."""

import os
import secrets
import stat
from pathlib import Path

_SHORTEST = 22
"""Characters of a token that nobody guesses: 128 bits."""


class TokenError(ValueError):
    """A token cannot be kept or read; one or two clear sentences."""


def new_token() -> str:
    """A token nobody has seen."""
    return secrets.token_urlsafe(32)


def load_or_create_token(path: Path) -> str:
    """The token of a file; one that is not there is made, for its owner alone.

    Raises:
        TokenError: others may read the file, it holds no token, or it cannot be used.
    """
    try:
        with open(path, encoding="ascii") as file:
            _refuse_shared(path, os.fstat(file.fileno()))
            token = file.read(1000).strip()
    except FileNotFoundError:
        return _make(path)
    except OSError as error:
        raise TokenError(f"The token file {path} cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError:
        token = ""
    if len(token) < _SHORTEST or not all(character.isalnum() or character in "-_" for character in token):
        raise TokenError(
            f"The file {path} holds no token: {_SHORTEST} or more letters, digits, - and _. "
            "Name a file that does not exist, and one is made."
        )
    return token


def _refuse_shared(path: Path, status: os.stat_result) -> None:
    if os.name == "posix" and stat.S_IMODE(status.st_mode) & 0o077:
        raise TokenError(f"Others may read the token file {path}: say chmod 600 {path}, or name another.")


def _make(path: Path) -> str:
    token = new_token()
    try:
        file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(file, "w", encoding="ascii") as kept:
            kept.write(f"{token}\n")
    except OSError as error:
        raise TokenError(f"The token file {path} cannot be made: {error.strerror}.") from error
    return token

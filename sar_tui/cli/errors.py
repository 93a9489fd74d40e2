"""Error handling of all commands: one or two sentences on stderr, and an exit code."""

import errno
import os
import re
import sys
from typing import Any

import typer
from typer.core import TyperGroup

from sar_tui.tui.exit_codes import BAD_INPUT, FAILED, INTERRUPTED

DEBUG = "SAR_TUI_DEBUG"

_LONG, _QUOTED = 300, 60
"""A word of this many characters is not quoted whole, but so many of its characters."""

_FULL = (errno.ENOSPC, errno.EDQUOT)
_DISK = {
    **dict.fromkeys(
        _FULL,
        "The disk is full: what was to be written is not complete. Free some space, and try again.",
    ),
    errno.EFBIG: "A file would be larger than the disk or this login may have. Write less, or to "
    "another disk.",
    errno.EIO: "The disk cannot be read or written: see that it is plugged in and whole, and try "
    "again.",
    errno.EROFS: "The disk can only be read. Name another one to write to.",
}
"""Failures of a disk, which the system often reports without the name of the file."""
_UsageError: type[Exception] = typer.BadParameter.__bases__[0]
"""The usage error of the click that typer uses, its own or another, depending on its version."""


class Refused(Exception):
    """Bad usage or input. The message is one or two clear sentences."""


class Commands(TyperGroup):
    """Group of commands that reports errors as sentences."""

    def invoke(self, ctx: Any) -> Any:
        try:
            result = super().invoke(ctx)
            sys.stdout.flush()
        except (typer.Exit, typer.Abort):
            raise
        except _UsageError as error:
            _remove_prefix(error)
            raise
        except KeyboardInterrupt:
            _print("Stopped.")
            raise typer.Exit(INTERRUPTED) from None
        except BrokenPipeError:
            _close_stdout()
            raise typer.Exit(FAILED) from None
        except Exception as error:
            raise typer.Exit(report(error)) from None
        return result


def report(error: Exception) -> int:
    """Print an error as a sentence, and return the exit code. With ``SAR_TUI_DEBUG``, raise it."""
    if os.environ.get(DEBUG):
        raise error
    code, sentence = explain(error)
    _print(sentence)
    return code


def explain(error: Exception) -> tuple[int, str]:
    """Return the exit code and the message for an error, even if parts of the program cannot be
    loaded.
    """
    try:
        return _expected(error) or (FAILED, _unexpected(error))
    except Exception as broken:
        return FAILED, _unexpected(broken)


def _unexpected(error: Exception) -> str:
    return (
        f"An unexpected error occurred ({type(error).__name__}: {error}). "
        f"Run the command again with {DEBUG}=1 to see where."
    )


def _expected(error: Exception) -> tuple[int, str] | None:
    """Return the exit code and the message of an expected error, else None."""
    import sqlite3

    from sar_tui.export.errors import ExportError
    from sar_tui.link.errors import LinkError
    from sar_tui.plugins import PluginError
    from sar_tui.rules.declaration import ParameterError
    from sar_tui.runs.plan import Failed
    from sar_tui.store import database

    match error:
        case database.StoreError() | ExportError():
            return BAD_INPUT if error.bad_input else FAILED, str(error)
        case Refused() | PluginError() | ParameterError() | LinkError():
            return BAD_INPUT, str(error)
        case Failed():
            return FAILED, str(error)
        case sqlite3.Error():
            return _expected(database.explain(error))
        case OSError() if error.filename or error.errno in _DISK:
            return _unusable(error)
    return _of_python(error)


def _of_python(error: Exception) -> tuple[int, str] | None:
    """Return the exit code and the message of an error that is known by Python's own words only,
    else None.
    """
    import shlex
    import sysconfig
    from pathlib import Path

    folders = (Path(__file__).parents[1], sysconfig.get_path("purelib"))
    known = {
        "can't start new thread": "The system starts no more threads for this login: close other "
        "programs, or raise "
        "the limit of processes (ulimit -u) or of memory (ulimit -v).",
        "marshal data too short": "A module that Python keeps compiled is cut short, as by a full "
        "disk. Make all anew: "
        f"{sys.executable} -m compileall -fq {shlex.join(map(str, folders))}",
    }
    sentence = next((known[said] for said in known if said in str(error)), None)
    return None if sentence is None else (FAILED, sentence)


def _unusable(error: OSError) -> tuple[int, str]:
    if error.errno in _FULL or (error.errno in _DISK and not error.filename):
        return FAILED, _DISK[error.errno]
    if error.errno == errno.ENAMETOOLONG:
        return BAD_INPUT, f"{error.filename} is too long for the name of a file or folder."
    return FAILED, f"{error.filename} cannot be used: {error.strerror}."


def _remove_prefix(error: Exception) -> None:
    """Remove the name of an exception, which some versions of typer put before the message."""
    said = getattr(error, "message", None)
    if isinstance(said, str):
        error.message = said.removeprefix("Value error, ")  # type: ignore[attr-defined]


def _print(sentence: str) -> None:
    print(
        re.sub(rf"\S{{{_LONG},}}", lambda word: f"{word[0][:_QUOTED]}…", sentence), file=sys.stderr
    )


def _close_stdout() -> None:
    """Redirect standard output, whose reader is gone, so that flushing it at exit does not fail."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())

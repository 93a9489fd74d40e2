"""How a command ends when something is wrong: one or two sentences on stderr, and an exit code."""

import os
import sys
from typing import Any

import typer
from typer.core import TyperGroup

from sar_tui import INTERRUPTED

FAILED, BAD_INPUT = 1, 2
DEBUG = "SAR_TUI_DEBUG"

_UsageError: type[Exception] = typer.BadParameter.__bases__[
    0
]  # typer brings its own click, or uses another, by its version


class Refused(Exception):
    """Bad usage or input; one or two clear sentences."""


class Commands(TyperGroup):
    """The commands, with their errors told in words."""

    def invoke(self, ctx: Any) -> Any:
        try:
            result = super().invoke(ctx)
            sys.stdout.flush()
        except (typer.Exit, typer.Abort):
            raise
        except _UsageError as error:
            _in_plain_words(error)
            raise
        except KeyboardInterrupt:
            _tell("Stopped.")
            raise typer.Exit(INTERRUPTED) from None
        except BrokenPipeError:
            _close_stdout()
            raise typer.Exit(FAILED) from None
        except Exception as error:
            if os.environ.get(DEBUG):
                raise
            code, sentence = explain(error)
            _tell(sentence)
            raise typer.Exit(code) from None
        return result


def explain(error: Exception) -> tuple[int, str]:
    """The exit code and the sentences for an error; also where the program is damaged, and parts of it do not load."""
    try:
        return _known(error) or (FAILED, _unforeseen(error))
    except Exception as broken:
        return FAILED, _unforeseen(broken)


def _unforeseen(error: Exception) -> str:
    return (
        f"Something went wrong that should not have ({type(error).__name__}: {error}). "
        f"Run it again with {DEBUG}=1 to see where."
    )


def _known(error: Exception) -> tuple[int, str] | None:
    """Of what is foreseen."""
    import sqlite3

    from sar_tui.framework.declaration import ParameterError
    from sar_tui.link.errors import LinkError
    from sar_tui.plugins import PluginError
    from sar_tui.runs.plan import Failed
    from sar_tui.store import database

    match error:
        case database.StoreError():
            return BAD_INPUT if error.bad_input else FAILED, str(error)
        case Refused() | PluginError() | ParameterError() | LinkError():
            return BAD_INPUT, str(error)
        case Failed():
            return FAILED, str(error)
        case sqlite3.Error():
            return _known(database.explain(error))
        case OSError() if error.filename:
            return FAILED, f"{error.filename} cannot be used: {error.strerror}."
    return None


def _in_plain_words(error: Exception) -> None:
    """Some versions of typer put the name of an exception before what is wrong with a value."""
    said = getattr(error, "message", None)
    if isinstance(said, str):
        error.message = said.removeprefix("Value error, ")  # type: ignore[attr-defined]


def _tell(sentence: str) -> None:
    print(sentence, file=sys.stderr)


def _close_stdout() -> None:
    """Nobody reads it any more: let nothing be written to it when the program ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())

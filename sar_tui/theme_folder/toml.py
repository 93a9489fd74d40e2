"""Reads a file of a theme, as people's editors leave it."""

import tomllib
from pathlib import Path
from typing import Any

from sar_tui.framework.theme import ThemeError

_LONGEST = 60


def printable(name: str) -> str:
    """A name as it can stand in a sentence: not too long, and nothing in it that a terminal would obey."""
    cut = name if len(name) <= _LONGEST else f"{name[:_LONGEST]}…"
    return "".join(character if character.isprintable() else "�" for character in cut)


def read_toml(path: Path) -> dict[str, Any]:
    """What a file says. Raises ThemeError: it is missing, or not TOML; one sentence."""
    try:
        return tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    except FileNotFoundError as error:
        raise ThemeError(f"There is no {path.name}.") from error
    except OSError as error:
        raise ThemeError(f"{path.name} cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError as error:
        line = path.read_bytes()[: error.start].count(b"\n") + 1
        raise ThemeError(f"{path.name} is not UTF-8 text from line {line} on; save it as UTF-8.") from error
    except (ValueError, RecursionError) as error:
        raise ThemeError(f"{path.name} is not TOML: {error}.") from error

"""Commands of this program, as they can be typed."""

import shlex
from collections.abc import Iterable
from pathlib import Path


def hint(said: str, command: str) -> str:
    """Return a sentence with a command on a line of its own, from which it can be copied."""
    return f"{said}\n  {command}"


def command_line(folder: Path, tasks: Iterable[Path], name: str, *arguments: str) -> str:
    """Return a command of this program with the folders that it was started with.

    Args:
        folder: of the data.
        tasks: additional folders of tasks.
        name: of the command: one word or several.
        arguments: of the command.
    """
    from sar_tui.store.database import default_folder

    parts = ["sar-tui", *name.split(), *arguments]
    if folder.resolve() != default_folder().resolve():
        parts += ["--data", str(folder)]
    for each in tasks:
        parts += ["--tasks", str(each)]
    return shlex.join(parts)

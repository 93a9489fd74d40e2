"""Lists what is installed: tasks or themes."""

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

T = TypeVar("T")
Row = dict[str, Any]


def installed(
    names: Iterable[str], load: Callable[[str], T], facts: Callable[[T], Row]
) -> tuple[list[Row], list[Row]]:
    """Return a row with the facts on each plug-in that loads, and one with the error of each that
    does not.
    """
    from sar_tui.plugins import PluginError

    rows: list[Row] = []
    broken: list[Row] = []
    for name in names:
        try:
            rows.append({"name": name, **facts(load(name))})
        except PluginError as error:
            broken.append({"name": name, "error": str(error)})
    return rows, broken


def replaced_lines(replaced: Mapping[str, Path]) -> list[str]:
    """Return a sentence for each of the user's own tasks that replaces a built-in one, given their
    folders by name.
    """
    return [
        f"{name}: your own in {folder} replaces the built-in one."
        for name, folder in replaced.items()
    ]

"""Lists what is installed: tasks or themes."""

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

T = TypeVar("T")
Row = dict[str, Any]


def installed(names: Iterable[str], load: Callable[[str], T], facts: Callable[[T], Row]) -> tuple[list[Row], list[Row]]:
    """Return a row with the facts on each plug-in that loads, and one with the error of each that does not."""
    from sar_tui.plugins import PluginError

    rows: list[Row] = []
    broken: list[Row] = []
    for name in names:
        try:
            rows.append({"name": name, **facts(load(name))})
        except PluginError as error:
            broken.append({"name": name, "error": str(error)})
    return rows, broken

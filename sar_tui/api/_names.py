"""Names of the front door that are not there from the start: loaded when first used, or retired."""

import sys
import warnings
from collections.abc import Callable, Mapping
from typing import Any

from sar_tui import API


def names_on_demand(
    door: str, loaded_later: Mapping[str, str], retired: Mapping[str, str]
) -> Callable[[str], Any]:
    """Return the ``__getattr__`` of a module of the front door.

    Args:
        door: name of the module.
        loaded_later: the names that each module of the program has, with spaces between: what few
            plug-ins need, or what loads numpy.
        retired: names that leave with the next number of the interface, each with the one to use
            instead.
    """
    homes = {name: home for home, names in loaded_later.items() for name in names.split()}

    def find(name: str) -> Any:
        if name in retired:
            new = retired[name]
            warning = f"{name} of {door} leaves with API {API + 1}. Use {new} instead."
            warnings.warn(warning, DeprecationWarning, stacklevel=2)
            return getattr(sys.modules[door], new)
        if name not in homes:
            raise AttributeError(f"module {door} has no name {name}")
        from importlib import import_module

        found = getattr(import_module(homes[name]), name)
        setattr(sys.modules[door], name, found)
        return found

    return find

"""Plug-ins of installed packages, by the group of their entry points."""

import functools
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


def entry_points(group: str) -> "tuple[EntryPoint, ...]":
    """Return the entry points of a group. They are looked for once, as that takes some
    milliseconds.
    """
    return _found(group, tuple(sys.path))


@functools.cache
def _found(group: str, _: tuple[str, ...]) -> "tuple[EntryPoint, ...]":
    from importlib import metadata

    return tuple(metadata.entry_points(group=group))

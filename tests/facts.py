"""Compares several fields of a message, or of many, in one line."""

from collections.abc import Iterable
from operator import attrgetter
from typing import Any


def facts(of: Any, names: str) -> tuple[Any, ...]:
    """Return the values of the named fields; a name may be dotted."""
    return tuple(attrgetter(name)(of) for name in names.split())


def each(many: Iterable[Any], names: str) -> list[Any]:
    """Return the named fields of each: tuples, or values if one is named."""
    return [found if len(found := facts(one, names)) > 1 else found[0] for one in many]

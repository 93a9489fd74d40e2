"""Differences between two sets of parameters, for people."""

from collections.abc import Mapping
from typing import Any

import msgspec

from sar_tui.framework.declaration import show
from sar_tui.framework.parameters import TaskParameters, current_values, fields


class Change(msgspec.Struct, frozen=True):
    """A parameter with two values. Its title is its name if it does not exist any more."""

    name: str
    title: str
    unit: str
    before: Any
    after: Any

    @property
    def text(self) -> str:
        """The change in words: "Goal 1000 → 900 ms"."""
        values = f"{show(self.before) or 'none'} → {show(self.after) or 'none'}"
        return " ".join(filter(None, (self.title, values, self.unit)))


def changes(
    parameters: type[TaskParameters], before: Mapping[str, Any], after: Mapping[str, Any]
) -> tuple[Change, ...]:
    """Return what differs between two sets of values, in the order of the declaration.

    A value that is missing is the default; of a parameter that does not exist any more it is None.
    """
    declared = {field.name: field for field in fields(parameters)}
    before, after = current_values(parameters, before), current_values(parameters, after)
    gone = [name for name in (*before, *after) if name not in declared]
    found = []
    for name in dict.fromkeys((*declared, *gone)):
        field = declared.get(name)
        default = field.default if field else None
        old, new = before.get(name, default), after.get(name, default)
        if show(old) != show(new):
            found.append(Change(name, field.title if field else name, field.unit if field else "", old, new))
    return tuple(found)

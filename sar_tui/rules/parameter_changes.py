"""Differences between two sets of parameters, for people."""

from collections.abc import Mapping
from typing import Any

import msgspec

from sar_tui.model.language import Language
from sar_tui.rules.declaration import show
from sar_tui.rules.parameters import TaskParameters, fields
from sar_tui.rules.translated_settings import translated


class Change(msgspec.Struct, frozen=True, omit_defaults=True):
    """A parameter with two values. Its title is its name if it does not exist any more.

    ``labels``: values as they are shown in another language.
    """

    name: str
    title: str
    unit: str
    before: Any
    after: Any
    labels: Mapping[str, str] = {}

    @property
    def text(self) -> str:
        """The change in words: "Goal 1000 → 900 ms"."""
        values = [
            self.labels.get(shown, shown) or "none"
            for shown in (show(self.before), show(self.after))
        ]
        return " ".join(filter(None, (self.title, " → ".join(values), self.unit)))


def changes(
    parameters: type[TaskParameters],
    before: Mapping[str, Any],
    after: Mapping[str, Any],
    tr: Language | None = None,
) -> tuple[Change, ...]:
    """Return what differs between two sets of values, in the order of the declaration; in a
    language, or English.

    A value that is missing is the default; of a parameter that does not exist any more it is None.
    """
    declared = {field.name: translated(field, tr or Language()) for field in fields(parameters)}
    gone = [name for name in (*before, *after) if name not in declared]
    found = []
    for name in dict.fromkeys((*declared, *gone)):
        field = declared.get(name)
        default = field.default if field else None
        old, new = before.get(name, default), after.get(name, default)
        if show(old) != show(new):
            title, unit, labels = (
                (field.title, field.unit, field.labels) if field else (name, "", {})
            )
            found.append(Change(name, title, unit, old, new, labels))
    return tuple(found)

"""Declared settings in another language: titles, units, meanings, groups and choices, as people
read them.
"""

from pathlib import Path

import msgspec

from sar_tui.model.language import Language
from sar_tui.rules.declaration import Field

COMMON = Path(__file__).parent / "settings"
"""The folder of the translations of common settings and of those of policies. A task's own are in
its folder.
"""


def translated(field: Field, tr: Language) -> Field:
    """Return a setting in another language. What has no translation stays English; its name and
    values are the same.
    """
    return msgspec.structs.replace(
        field,
        title=tr(field.title),
        unit=tr(field.unit),
        help=tr(field.help),
        takes=tr(field.takes),
        group=tr(field.group),
        labels={choice: own for choice in field.choices if (own := tr(choice)) != choice},
    )


def texts(field: Field) -> set[str]:
    """Return the texts of a setting that have a translation."""
    return {field.title, field.unit, field.help, field.takes, field.group} - {""}

"""The formats of an export: the bundled ones, and those of installed packages."""

from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Protocol

from sar_tui.export.errors import ExportError
from sar_tui.plugin_calls import WrongApi, check_api

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from sar_tui.export.contents import Contents

GROUP = "sar_tui.exports"
"""Entry points of this group name a class like `Format`."""
BUNDLED = {
    "csv": "sar_tui.export.formats.csv:CsvFormat",
    "mat": "sar_tui.export.formats.mat:MatFormat",
    "elan": "sar_tui.export.formats.elan:ElanFormat",
    "parquet": "sar_tui.export.formats.parquet:ParquetFormat",
    "bids": "sar_tui.export.formats.bids.format:BidsFormat",
    "psych-ds": "sar_tui.export.formats.psych_ds:PsychDsFormat",
}
"""Each bundled format by its name: its module, and there its class."""


class Format(Protocol):
    """A format. Its class is called without arguments.

    Attributes:
        name: as in ``--format``.
        title: what it writes, in a few words.

    A class may have ``by_site = True``: it is then called for each site, and writes a table into
    ``TABLE/site=CODE``.
    """

    name: ClassVar[str]
    title: ClassVar[str]

    def write(self, contents: "Contents", folder: Path, progress: Callable[[], None]) -> None:
        """Write the contents as files into an empty folder.

        Args:
            contents: tables, columns and rows; nothing else may leave.
            progress: called after each session, or participant, of each table: ``contents.steps``
                times in all.
        """


@cache
def _installed() -> "dict[str, EntryPoint]":
    from importlib.metadata import entry_points

    return {entry.name: entry for entry in entry_points(group=GROUP)}


def names() -> list[str]:
    """Return the names of all formats. A bundled one comes before an installed one of the same
    name.
    """
    return [*BUNDLED, *sorted(set(_installed()) - set(BUNDLED))]


def load(name: str) -> Format:
    """Return a format. Raises ExportError if there is none of that name, or it cannot be loaded."""
    if name in BUNDLED:
        module, _, attribute = BUNDLED[name].partition(":")
        made: Format = getattr(import_module(module), attribute)()
        return made
    if name not in _installed():
        raise ExportError(
            f"There is no format {name}. Choose one of: {', '.join(names())}.", bad_input=True
        )
    try:
        kind = _installed()[name].load()
        check_api("format", name, kind)
        made = kind()
    except WrongApi as error:
        raise ExportError(str(error)) from error
    except Exception as error:
        raise ExportError(
            f"The format {name} cannot be loaded: {type(error).__name__}: {error}"
        ) from error
    if not callable(getattr(made, "write", None)):
        raise ExportError(f"The format {name} has no method write: see docs/export-data.md.")
    return made

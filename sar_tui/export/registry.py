"""The formats of an export: the bundled ones, and those of installed packages."""

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Protocol

from sar_tui.export.errors import ExportError
from sar_tui.plugin_loader import Group

if TYPE_CHECKING:
    from sar_tui.export.contents import Contents

_INSTALLED = Group("sar_tui.exports", "format", ExportError)
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


def names() -> list[str]:
    """Return the names of all formats. A bundled one comes before an installed one of the same
    name.
    """
    return [*BUNDLED, *sorted(_INSTALLED.names() - set(BUNDLED))]


def load(name: str) -> Format:
    """Return a format. Raises ExportError if there is none of that name, or it cannot be loaded."""
    if name in BUNDLED:
        module, _, attribute = BUNDLED[name].partition(":")
        made: Format = getattr(import_module(module), attribute)()
        return made
    made = _INSTALLED.load(name, lambda kind: kind())
    if made is None:
        raise ExportError(
            f"There is no format {name}. Choose one of: {', '.join(names())}.", bad_input=True
        )
    if not callable(getattr(made, "write", None)):
        raise ExportError(f"The format {name} has no method write: see docs/export-data.md.")
    return made

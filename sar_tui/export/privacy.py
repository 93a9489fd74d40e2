"""Rules of privacy, which every value passes before a format sees it."""

from collections.abc import Iterator

import msgspec

from sar_tui.export.columns import Column, Table, Values


class Privacy(msgspec.Struct, frozen=True):
    """Rules on the way out. What a column holds, and what never leaves, is in `export.inventory`.

    Attributes:
        with_notes: texts that somebody may have typed leave, too.
    """

    with_notes: bool = False

    def leaves(self, column: Column) -> bool:
        """Return True if the values of a column may leave."""
        return column.treatment != "text" or self.with_notes

    def leaving(self, table: Table) -> Table:
        """Return a table with the columns that leave."""
        return msgspec.structs.replace(table, columns=tuple(filter(self.leaves, table.columns)))

    def changed(self, table: Table, rows: Iterator[Values]) -> Iterator[Values]:
        """Yield the rows of a table as they leave."""
        return rows

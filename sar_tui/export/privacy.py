"""Rules of privacy, which every value passes before a format sees it."""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import msgspec

from sar_tui.export.columns import Column, Table, Values
from sar_tui.export.recoding import Recoded, shifted


class Privacy(msgspec.Struct, frozen=True):
    """Rules on the way out. What a column holds, and what never leaves, is in `export.inventory`.

    Attributes:
        with_notes: texts that somebody may have typed leave, too.
        recoded: the participants' codes and date shifts in the export; None if codes and dates leave as they are.
        of_site: the site whose data these are, and that of the database; None if codes leave as they are stored here.
    """

    with_notes: bool = False
    recoded: Mapping[str, Recoded] | None = None
    of_site: tuple[str, str] | None = None

    def code(self, participant: str) -> str:
        """Return a participant's code as it leaves.

        In the data of a site its own participants are P01, and those of other sites P01@BERN, in whichever database
        the data are.
        """
        if self.recoded is not None:
            return self.recoded[participant].code
        if self.of_site is None:
            return participant
        site, here = self.of_site
        return (participant if "@" in participant else f"{participant}@{here}").removesuffix(f"@{site}")

    def moment(self, stamp: str | None, participant: str) -> str | None:
        """Return a date, with or without the time of day, as it leaves."""
        if stamp is None or self.recoded is None:
            return stamp
        return shifted(stamp, days=self.recoded[participant].shift_days)

    def leaves(self, column: Column) -> bool:
        """Return True if the values of a column may leave."""
        return column.treatment != "text" or self.with_notes

    def leaving(self, table: Table) -> Table:
        """Return a table with the columns that leave."""
        return msgspec.structs.replace(table, columns=tuple(filter(self.leaves, table.columns)))

    def changed(self, table: Table, rows: Iterator[Values], participant: str) -> Iterator[Values]:
        """Yield rows as they leave.

        Args:
            table: with the columns that leave, as `leaving` returns it.
            participant: the person by whose shift their dates are shifted.
        """
        changes: dict[str, Callable[[str], str | None]] = {}
        if self.recoded is not None or self.of_site is not None:
            changes["code"] = self.code
        if self.recoded is not None:
            changes["time"] = partial(self.moment, participant=participant)
        which = [(index, changes[c.treatment]) for index, c in enumerate(table.columns) if c.treatment in changes]
        return (_changed(row, which) for row in rows) if which else rows


def _changed(row: Values, which: list[tuple[int, Callable[[str], str | None]]]) -> Values:
    values: list[Any] = list(row)
    for index, change in which:
        if values[index] is not None:
            values[index] = change(values[index])
    return tuple(values)

"""Rules of privacy, which every value passes before a format sees it."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import msgspec

from sar_tui.export.columns import Column, Table, Values
from sar_tui.export.recoding import Recoding, shifted
from sar_tui.export.run_time import RunStarts, without_dates

Change = Callable[[Any, Values], Any]
"""A function from a value, and the row that it is in, to the value as it leaves."""


class Privacy(msgspec.Struct, frozen=True):
    """Rules on the way out. What a column holds, and what never leaves, is in `store.tables`.

    Attributes:
        with_notes: texts that somebody may have typed leave, too.
        recoded: codes, date shifts and the key of ids in the export; None if all that leaves is as
            it is here.
        of_site: the site whose data these are, and that of the database; None if codes leave as
            they are stored here.
        differing: columns with the treatment ``version`` whose values are not the same in all
            sessions.
    """

    with_notes: bool = False
    recoded: Recoding | None = None
    of_site: tuple[str, str] | None = None
    differing: frozenset[str] = frozenset()

    def code(self, participant: str) -> str:
        """Return a participant's code as it leaves.

        In the data of a site its own participants are P01, and those of other sites P01@BERN, in
        whichever database the data are.
        """
        if self.recoded is not None:
            return self.recoded.people[participant].code
        if self.of_site is None:
            return participant
        site, here = self.of_site
        return (participant if "@" in participant else f"{participant}@{here}").removesuffix(
            f"@{site}"
        )

    def moment(self, stamp: str | None, participant: str) -> str | None:
        """Return a date, with or without the time of day, as it leaves."""
        if stamp is None or self.recoded is None:
            return stamp
        return shifted(stamp, days=self.recoded.people[participant].shift_days)

    def id(self, known_here: str) -> str:
        """Return the id of a session, or of an adverse event, as it leaves."""
        return known_here if self.recoded is None else self.recoded.id(known_here)

    def leaves(self, column: Column) -> bool:
        """Return True if the values of a column may leave."""
        if column.treatment == "version" and self.recoded is not None:
            return column.name not in self.differing
        if column.treatment in ("zone", "hash"):
            return self.recoded is None
        return column.treatment != "text" or self.with_notes

    def leaving(self, table: Table) -> Table:
        """Return a table with the columns that leave."""
        return msgspec.structs.replace(table, columns=tuple(filter(self.leaves, table.columns)))

    def changed(
        self, table: Table, rows: Iterator[Values], participant: str, starts: RunStarts | None
    ) -> Iterator[Values]:
        """Yield rows as they leave.

        Args:
            table: with the columns that leave, as `leaving` returns it.
            participant: the person by whose shift their dates are shifted.
            starts: of the runs of the session; None for rows of a person.
        """
        if self.recoded is not None:
            changes = self._recoding(table, self.recoded, participant, starts)
        elif self.of_site is not None:
            changes = {
                index: lambda value, _: self.code(value)
                for index, column in enumerate(table.columns)
                if column.treatment == "code"
            }
        else:
            changes = {}
        return (_changed(row, changes) for row in rows) if changes else rows

    def _recoding(
        self, table: Table, recoded: Recoding, participant: str, starts: RunStarts | None
    ) -> dict[int, Change]:
        """Return what becomes of the values of each column of a table, by its place."""
        run_of = _runs(table, starts)
        days = recoded.people[participant].shift_days
        found: dict[int, Change] = {}
        for index, column in enumerate(table.columns):
            match column.treatment:
                case "code":
                    found[index] = lambda value, _: self.code(value)
                case "id":
                    found[index] = _once(recoded.id)
                case "seed":
                    found[index] = lambda value, _: recoded.seed(value)
                case "time":
                    found[index] = lambda value, _: shifted(value, days)
                case "clock" if starts is not None:
                    found[index] = _since_start(starts, run_of(column))
                case "sensor clock":
                    found[index] = _since_first(table)
                case _ if column.tasks is not None and starts is not None:
                    found[index] = _of_task(column, starts, run_of(column), days)
        return found


RunOf = Callable[[Values], int | None]


def _runs(table: Table, starts: RunStarts | None) -> Callable[[Column], RunOf]:
    """Return a function from a column to what tells the run of its stamps from a row."""
    names = [column.name for column in table.columns]

    def run_of(column: Column) -> RunOf:
        own = (
            f"{column.name.removesuffix('_ns')}_run"  # an attempt may have begun in an earlier run
        )
        if own not in names and "run" not in names:
            stream = names.index("stream")
            return lambda row: starts.runs_of_streams.get(row[stream]) if starts else None
        place = names.index(own if own in names else "run")
        return lambda row: row[place]

    return run_of


def _once(change: Callable[[str], str]) -> Change:
    """Return a change that is computed once for each value: a session has one id in millions of
    samples.
    """
    known: dict[str, str] = {}

    def changed(value: str, row: Values) -> str:
        if value not in known:
            known[value] = change(value)
        return known[value]

    return changed


def _since_start(starts: RunStarts, run_of: RunOf) -> Change:
    return lambda stamp, row: starts.since(stamp, run_of(row))


def _since_first(table: Table) -> Change:
    """Return what makes readings of a sensor's clock count from its first one."""
    stream = [column.name for column in table.columns].index("stream")
    firsts: dict[Any, float] = {}
    return lambda reading, row: reading - firsts.setdefault(row[stream], reading)


def _of_task(column: Column, starts: RunStarts, run_of: RunOf, days: int) -> Change:
    return lambda value, row: without_dates(
        column.name, value, starts.clocks.get(run_of(row) or 0), days
    )


def _changed(row: Values, changes: Mapping[int, Change]) -> Values:
    values: list[Any] = list(row)
    for index, change in changes.items():
        if values[index] is not None:
            values[index] = change(values[index], row)
    return tuple(values)

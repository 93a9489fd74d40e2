"""Seconds since a session began, from the stamps of all its runs."""

from collections.abc import Mapping
from datetime import datetime, timedelta

import msgspec

from sar_tui.export.contents import Contents

_NS_PER_S = 1_000_000_000
_NS_PER_MS = 1_000_000


class SessionClock(msgspec.Struct, frozen=True):
    """A clock that is 0 when the first run of a session began.

    The steady clock of a later run may have begun anew. Its stamps are related by the time of day
    at which the runs began, so they are as exact as the computer's calendar clock; within a run
    they are exact.

    Attributes:
        zeros: for each run, its steady clock at 0, in ns.
    """

    zeros: Mapping[int, int]

    def seconds(self, run: int | None, at_ns: int | None) -> float | None:
        """Return a stamp of a run in seconds, rounded once; None if one of both is missing or the
        run is not known.
        """
        zero = self.zero(run)
        return None if zero is None or at_ns is None else (at_ns - zero) / _NS_PER_S

    def milliseconds(self, run: int | None, at_ns: int | None) -> int | None:
        """Return a stamp in whole ms, as `seconds`; 0 if it is before."""
        zero = self.zero(run)
        return None if zero is None or at_ns is None else max(0, round((at_ns - zero) / _NS_PER_MS))

    def zero(self, run: int | None) -> int | None:
        """Return the steady clock of a run at 0, in ns; None if the run is not known."""
        return None if run is None else self.zeros.get(run)


def session_clock(contents: Contents, session: str) -> SessionClock:
    """Return the clock of a session. Runs whose start is not stored are not known."""
    (table,) = (table for table in contents.tables if table.name == "runs")
    names = [column.name for column in table.columns]
    zeros: dict[int, int] = {}
    began = None
    for values in contents.rows(table, session):
        row = dict(zip(names, values, strict=True))
        try:
            utc = datetime.fromisoformat(row["clock_utc"])
            zero = row["clock_ns"] - (utc - (began or utc)) // timedelta(microseconds=1) * 1000
        except (TypeError, ValueError):  # damaged, or missing
            continue
        began = began or utc
        zeros[row["run"]] = zero
    return SessionClock(zeros)

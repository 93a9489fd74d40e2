"""Stamps as time since the start of their run, and dates in what tasks keep: both are changed in
recoded exports.

The steady clock goes on from session to session until the machine is started anew. In an export
with shifted dates, one known date and the stamps as they are would tell the true dates of everybody
who trained on the machine.
"""

import math
import re
import sqlite3
from collections.abc import Mapping
from datetime import datetime
from typing import Any

import msgspec

from sar_tui.export.recoding import shifted

_NS_PER_S = 10**9
_BEFORE = 600 * _NS_PER_S
"""A sensor may be attached some minutes before the run of its session begins, if the machine is on
for longer.
"""
_LATEST = 7 * 86_400 * _NS_PER_S
_LEAST = 100 * _NS_PER_S
"""A number below is a stamp only if its name ends with ``_ns``: it may be anything else."""
_A_DAY_S = 86_400
_UNITS = {"s": 1, "ms": 10**3, "us": 10**6, "ns": _NS_PER_S}
_EPOCH = (datetime(2015, 1, 1).timestamp(), datetime(2100, 1, 1).timestamp())
"""Numbers in this range, in seconds or parts of them, may be times of day since 1970."""
_DATE = re.compile(r"\d{4}-\d\d-\d\d(?:[T ]\d\d:\d\d(?::\d\d(?:\.\d+)?)?(?:Z|[+-]\d\d:?\d\d)?)?")


class RunStarts(msgspec.Struct, frozen=True):
    """The steady clock at the start of each run of a session, and the run of each of its
    sensors.
    """

    clocks: Mapping[int, int]
    runs_of_streams: Mapping[int, int]

    def since(self, stamp: Any, run: int | None) -> Any:
        """Return a stamp, or several with spaces between them, in ns since the start of their run.

        Return None if they are not of that run: such a number would tell the clock.
        """
        start = None if run is None else self.clocks.get(run)
        if start is None:
            return None
        if isinstance(stamp, str):
            found = [
                self.since(int(part), run) if part.isdecimal() else None for part in stamp.split()
            ]
            return None if None in found else " ".join(map(str, found))
        since = stamp - start
        return since if -min(_BEFORE, start // 2) <= since <= _LATEST else None


def run_starts(database: sqlite3.Connection, session: str) -> RunStarts:
    """Return the starts of the runs of a session: by their anchors, or by the first message if one
    is damaged.
    """
    first = (
        "SELECT run, min(at_ns) FROM messages WHERE session_number=(SELECT number FROM"
        " session_numbers WHERE id=?) GROUP BY run"
    )
    anchors = dict(
        database.execute(
            "SELECT run, CAST(clock_anchor AS BLOB) FROM runs WHERE session=?", (session,)
        ).fetchall()
    )
    clocks = {
        run: start for run, anchor in anchors.items() if (start := _start(anchor)) is not None
    }
    if not clocks or len(clocks) < len(anchors):
        clocks = {
            run: at for run, at in database.execute(first, (session,)) if isinstance(at, int)
        } | clocks
    streams = database.execute("SELECT stream, run FROM imu_streams WHERE session=?", (session,))
    return RunStarts(clocks, dict(streams.fetchall()))


def _start(anchor: bytes | None) -> int | None:
    try:
        clock = msgspec.json.decode(anchor or b"null")["clock_ns"]
    except (msgspec.DecodeError, KeyError, TypeError):
        return None
    return clock if isinstance(clock, int) else None


def without_dates(name: str, value: Any, start: int | None, days: int) -> Any:
    """Return what a task keeps, such as a detail of a trial, with stamps and dates as they leave.

    A number that can be a stamp of the run counts from its start. One that can be a time of day
    since 1970, and a text that is a date, are shifted.

    Args:
        name: of the column; ``_ns`` at its end says that a small number may be a stamp, too.
        start: the steady clock at the start of the run; None if it is not known.
        days: by which the dates of the person are shifted.
    """
    match value:
        case bool() | None:
            return value
        case int() | float():
            return _number(value, start, days, is_ns=name.endswith("_ns"))
        case str():
            return _text(name, value, start, days)
        case list():
            return [without_dates(name, each, start, days) for each in value]
        case _:
            return {key: without_dates(key, each, start, days) for key, each in value.items()}


def _text(name: str, text: str, start: int | None, days: int) -> str | None:
    if text[:1] in ("[", "{"):
        return _of_json(name, text, start, days)
    return shifted(text, days) if _DATE.fullmatch(text) else text


def _of_json(name: str, text: str, start: int | None, days: int) -> str:
    try:
        found = msgspec.json.decode(text)
    except msgspec.DecodeError:
        return text
    return msgspec.json.encode(without_dates(name, found, start, days)).decode()


def _number(value: float, start: int | None, days: int, *, is_ns: bool) -> float:
    if not math.isfinite(value):
        return value
    if start is not None and start <= value <= start + _LATEST and (is_ns or value >= _LEAST):
        return value - start
    for unit, a_second in _UNITS.items():
        is_time = _EPOCH[0] <= value / a_second <= _EPOCH[1]
        # a whole number so small is rather a seed
        if is_time and (unit != "s" or isinstance(value, float)):
            return value + days * _A_DAY_S * a_second
    return value

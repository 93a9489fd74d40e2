"""Motion sensors, their faults, and their samples: a row for each."""

import sqlite3
import zlib
from collections.abc import Callable, Iterator
from functools import partial
from itertools import repeat
from typing import TYPE_CHECKING

import msgspec

from sar_tui.export.columns import (
    PARTICIPANT,
    SEAT,
    SESSION,
    TO_SESSION,
    Column,
    Reference,
    Row,
    Stored,
    Table,
    Values,
    codes_by_seat,
    in_order,
    stored,
    with_others,
)
from sar_tui.export.damage import Damage
from sar_tui.export.log import messages_of_topic
from sar_tui.loop.topics import SENSOR, TRUNK_SENSOR
from sar_tui.store.imu import layout
from sar_tui.store.tables import IMU_STREAMS as STORED_STREAMS

if TYPE_CHECKING:
    from sar_tui.motion.samples import Floats

_KEY = ("session", "stream")
_PARTS = STORED_STREAMS["part"].levels
_QUANTITIES = ("acceleration", "rate", "field")
_STREAM = stored("imu_streams.stream")
_TO_STREAM = Reference(_KEY, "imu_streams", _KEY)


_STREAMS = Stored(STORED_STREAMS)
_STREAM_COLUMNS = with_others(_STREAMS.columns, {"stream": [PARTICIPANT]})


def _streams(database: sqlite3.Connection, session: str) -> Iterator[Row]:
    codes = codes_by_seat(database, session)
    for row in _STREAMS.rows(database, session):
        row["participant"] = codes.get(row["seat"])
        yield row


IMU_STREAMS = Table(
    name="imu_streams",
    title=STORED_STREAMS.row,
    columns=_STREAM_COLUMNS,
    key=_KEY,
    rows=in_order(_STREAM_COLUMNS, _streams),
    references=(TO_SESSION,),
)


def _axes(part: str) -> list[Column]:
    found = stored(f"imu_chunks.data.{part}")
    return [
        msgspec.structs.replace(
            found, name=f"{part}_{axis}", meaning=found.meaning.format(axis=axis)
        )
        for axis in "xyz"
    ]


def imu(report: Callable[[str], None]) -> Table:
    """Return the table of samples.

    Args:
        report: is told of each block that is damaged and left out, in a sentence.
    """
    return Table(
        name="imu",
        title="A sample of a motion sensor",
        columns=(
            SESSION,
            _STREAM,
            stored("imu_chunks.data.at"),
            stored("imu_chunks.data.host"),
            stored("imu_chunks.data.device_ms"),
            *(column for name in _QUANTITIES for column in _axes(name)),
        ),
        key=(),
        rows=partial(_samples, report),
        references=(_TO_STREAM,),
    )


def _samples(
    report: Callable[[str], None], database: sqlite3.Connection, session: str
) -> Iterator[Values]:
    from sar_tui.motion.samples import SAMPLE, unpack

    _check_layouts(report, database, session)
    for stream, seq, number, crc, data in database.execute(
        "SELECT stream, seq, n, crc32, data FROM imu_chunks WHERE session=? ORDER BY stream, seq",
        (session,),
    ):
        if zlib.crc32(data) != crc or len(data) != number * SAMPLE.itemsize:
            report(
                f"Block {seq} of sensor stream {stream} of session {session} is damaged: its "
                f"{number} samples are left "
                "out."
            )
            continue
        samples = unpack(data)
        measured = [
            samples["device_ms"],
            *(samples[name][:, axis] for name in _QUANTITIES for axis in range(3)),
        ]
        columns = [_numbers(each) for each in measured]
        yield from zip(
            repeat(session),
            repeat(stream),
            samples["at"].tolist(),
            samples["host"].tolist(),
            *columns,
        )


def _check_layouts(
    report: Callable[[str], None], database: sqlite3.Connection, session: str
) -> None:
    """Report layouts that are damaged: there has only been one, so the samples can be read all the
    same.
    """
    for stream, found in database.execute(
        "SELECT stream, CAST(layout AS BLOB) FROM imu_streams WHERE session=? ORDER BY stream",
        (session,),
    ):
        if found != layout().encode():
            report(
                f"The layout of sensor stream {stream} of session {session} is damaged: its "
                "samples were read as this "
                "version stores them."
            )


def _numbers(values: "Floats") -> list[float | None]:
    """Return measured numbers; what a sensor does not measure is NaN in its samples."""
    from numpy import isfinite  # imports numpy, which an export without a sensor does not need

    is_measured = isfinite(values)
    found: list[float | None] = values.tolist()
    if is_measured.all():
        return found
    return [
        value if known else None for value, known in zip(found, is_measured.tolist(), strict=True)
    ]


def _faults(damage: Damage, database: sqlite3.Connection, session: str) -> Iterator[Values]:
    number = 0
    for part, topic in zip(_PARTS, (SENSOR, TRUNK_SENSOR), strict=True):
        for run, at, found in messages_of_topic(database, session, topic.name, damage):
            if found.get("state") not in _STATES:
                continue
            number += 1
            lost = found.get("count") or None
            yield (session, number, found.get("seat") or "A", part, run, found.get("at") or at, found["state"], lost,
                   found.get("duration_ms") or None)  # fmt: skip


_STATES = ("detached", "error", "gap", "saturated", "stalled")


def sensor_faults(damage: Damage) -> Table:
    """Return the table of the faults of motion sensors."""
    return Table(
        name="sensor_faults",
        title="A fault of a motion sensor, such as a gap in its samples",
        columns=(
            SESSION,
            Column(
                "fault",
                "Number of the fault in its session, from 1.",
                "integer",
                required=True,
                treatment="open",
            ),
            SEAT,
            stored("imu_streams.part"),
            stored("messages.run", required=False),
            stored("messages.at_ns", meaning="When it was noticed, steady clock of the run."),
            Column(
                "state",
                "What happened; a gap is missing samples.",
                "string",
                levels=_STATES,
                required=True,
                treatment="open",
            ),
            Column(
                "samples",
                "Number of samples that are missing or wrong.",
                "integer",
                treatment="open",
            ),
            Column("duration_ms", "Duration of the gap.", "number", unit="ms", treatment="open"),
        ),
        key=("session", "fault"),
        rows=partial(_faults, damage),
        references=(TO_SESSION,),
    )

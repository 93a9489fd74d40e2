"""Motion sensors, their faults, and their samples: a row for each."""

import sqlite3
import zlib
from collections.abc import Callable, Iterator
from functools import partial
from itertools import repeat
from typing import TYPE_CHECKING

from sar_tui.export.columns import (
    PARTICIPANT,
    SEAT,
    SESSION,
    TO_SESSION,
    Column,
    Reference,
    Table,
    Values,
    stored,
)
from sar_tui.export.damage import Damage
from sar_tui.export.messages_of_topic import messages_of_topic
from sar_tui.export.seats import codes_by_seat
from sar_tui.loop.topics import SENSOR, TRUNK_SENSOR
from sar_tui.store.imu import layout

if TYPE_CHECKING:
    from sar_tui.motion.samples import Floats

_KEY = ("session", "stream")
_PARTS = ("hand", "trunk")
_STREAM = stored(
    "imu_streams.stream", "integer", "Number of the stream in its session, from 1.", required=True
)
_TO_STREAM = Reference(_KEY, "imu_streams", _KEY)


def _streams(database: sqlite3.Connection, session: str) -> Iterator[Values]:
    codes = codes_by_seat(database, session)
    for stream, seat, *rest in database.execute(
        "SELECT stream, seat, part, run, model, rate_hz, rate_range_rad_s, "
        "acceleration_range_m_s2, attached_ns"
        " FROM imu_streams WHERE session=? ORDER BY stream",
        (session,),
    ):
        yield (session, stream, codes.get(seat), seat, *rest)


IMU_STREAMS = Table(
    name="imu_streams",
    title="A motion sensor, from the moment it was attached",
    columns=(
        SESSION,
        _STREAM,
        PARTICIPANT,
        SEAT,
        stored(
            "imu_streams.part", "string", "The part of the body with the sensor.", levels=_PARTS
        ),
        stored("imu_streams.run", "integer", "The run of the program."),
        stored("imu_streams.model", "string", "Model of the sensor."),
        stored("imu_streams.rate_hz", "number", "Its nominal samples a second.", unit="Hz"),
        stored(
            "imu_streams.rate_range_rad_s",
            "number",
            "Largest angular rate it measures; 0: unknown.",
            unit="rad/s",
        ),
        stored(
            "imu_streams.acceleration_range_m_s2",
            "number",
            "Largest acceleration it measures; 0: unknown.",
            unit="m/s^2",
        ),
        stored(
            "imu_streams.attached_ns",
            "integer",
            "When it was attached, steady clock of the run.",
            unit="ns",
        ),
    ),
    key=_KEY,
    rows=_streams,
    references=(TO_SESSION,),
)


def _axes(part: str, meaning: str, unit: str) -> list[Column]:
    return [
        stored(
            f"imu_chunks.data.{part}",
            "number",
            f"{meaning}, axis {axis}.",
            name=f"{part}_{axis}",
            unit=unit,
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
            stored("imu_chunks.data.at", "integer", "When it was measured, steady clock of the run.", name="at_ns",
                   unit="ns", required=True),
            stored("imu_chunks.data.host", "integer", "When it arrived, same clock.", name="host_ns", unit="ns"),
            stored("imu_chunks.data.device_ms", "number", "The sensor's own clock.", unit="ms"),
            *_axes("acceleration", "Acceleration", "m/s^2"),
            *_axes("rate", "Angular rate", "rad/s"),
            *_axes("field", "Magnetic field", "gauss"),
        ),
        key=(),
        rows=partial(_samples, report),
        references=(_TO_STREAM,),
    )  # fmt: skip


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


_QUANTITIES = ("acceleration", "rate", "field")


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
            stored(
                "sensor.number",
                "integer",
                "Number of the fault in its session, from 1.",
                name="fault",
                required=True,
            ),
            SEAT,
            stored("sensor.part", "string", "The part of the body with the sensor.", levels=_PARTS),
            stored("messages.run", "integer", "The run of the program."),
            stored(
                "messages.at_ns",
                "integer",
                "When it was noticed, steady clock of the run.",
                unit="ns",
            ),
            stored(
                "sensor.state",
                "string",
                "What happened; a gap is missing samples.",
                levels=_STATES,
                required=True,
            ),
            stored(
                "sensor.count",
                "integer",
                "Number of samples that are missing or wrong.",
                name="samples",
            ),
            stored("sensor.duration_ms", "number", "Duration of the gap.", unit="ms"),
        ),
        key=("session", "fault"),
        rows=partial(_faults, damage),
        references=(TO_SESSION,),
    )

"""Motion-BIDS: ``_motion.tsv`` without a header, its channels, and what is known of the sensor."""

from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import Any

import msgspec

from sar_tui.export.formats.bids.study import Row, Session, Study
from sar_tui.export.formats.bids.tsv import line, seconds, write_json, write_rows

_NO_FIELD = [None, None, None]
GAP_STEPS = 1.5
"""A step between samples of more than this many intervals of the nominal rate is a gap."""
_MISSING_VALUES = (
    "n/a. Where samples are missing, there is one row of n/a, whose latency is that "
    "of the first missing sample."
)
_TYPES = {"acceleration": "ACCEL", "rate": "GYRO", "field": "MAGN"}
_UNITS = {"acceleration": "m/s^2", "rate": "rad/s", "field": "gauss"}
_HEAD = (
    "name", "component", "type", "tracked_point", "units", "placement", "reference_frame", "description", "status",
    "status_description",
)  # fmt: skip
_CHANNELS = (
    ("latency", None, "LATENCY", "s", "Time since the first sample, by the host's steady clock."),
    *(
        (f"{name}_{axis}", axis, _TYPES[name], _UNITS[name], f"{meaning}, axis {axis}.")
        for name, meaning in (
            ("acceleration", "Acceleration"),
            ("rate", "Angular rate"),
            ("field", "Magnetic field"),
        )
        for axis in "xyz"
    ),
    ("device_clock", None, "MISC", "ms", "The sensor's own clock."),
    (
        "arrival",
        None,
        "MISC",
        "s",
        "When the sample arrived at the host, since the first sample was measured.",
    ),
)
_PLACES = {"hand": ("hand", "back of the hand"), "trunk": ("trunk", "sternum")}
"""Tracked point and placement of a sensor, by the part of the body."""
_FRAME = {
    "reference_frame": {
        "Description": "The axes of a channel are those of this frame.",
        "Levels": {
            "sensor": {
                "Description": "The axes printed on the sensor. As sar-tui asks for it to be "
                "worn: y along the "
                "fingers, z out of the back of the hand; on the trunk, in any way.",
            }
        },
    }
}


class Recording(msgspec.Struct, kw_only=True):
    """The samples of a sensor, from one attachment of it to the next.

    Attributes:
        first_ns, last_ns: stamps of the first and the last sample.
        gaps: number of places where samples are missing.
        has_field: True if the magnetic field was measured.
    """

    tracksys: str
    run: int
    path: str
    first_ns: int = 0
    last_ns: int = 0
    samples: int = 0
    gaps: int = 0
    has_field: bool = False


def write_motion(
    study: Study, session: Session, facts: dict[str, Any], folder: Path
) -> Iterator[Recording]:
    """Write the samples of the subject's sensors, and yield each recording. A sensor without a
    sample has no file.

    Args:
        facts: about the task.
        folder: of the session.
    """
    streams = {
        row["stream"]: row
        for row in study.rows("imu_streams", session.id)
        if row["seat"] == session.seat
    }
    if not streams:
        return
    for number, samples in groupby(study.values("imu", session.id), key=lambda row: row[1]):
        stream = streams.get(number)
        if stream is None:
            continue
        run, tracksys = stream["run"] or 1, f"imu{number}"
        path = session.path("motion", "motion.tsv", run, tracksys=tracksys)
        recording = Recording(tracksys=tracksys, run=run, path=path)
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        _write_samples(recording, stream["rate_hz"] or 0.0, samples, folder / path)
        _write_channels(
            recording,
            stream["part"],
            folder / session.path("motion", "channels.tsv", run, tracksys=tracksys),
        )
        about = {**facts, **_about(recording, stream)}
        write_json(folder / session.path("motion", "motion.json", run, tracksys=tracksys), about)
        yield recording


def describe_motion(study: Study, task: str, folder: Path) -> None:
    """Write what the channels of a task's recordings mean."""
    write_json(folder / f"task-{study.tasks[task]}_channels.json", _FRAME)


def _write_samples(
    recording: Recording, rate_hz: float, samples: Iterator[tuple[Any, ...]], path: Path
) -> None:
    interval = 1e9 / rate_hz if rate_hz > 0 else 0.0
    step = GAP_STEPS * interval or float("inf")
    missing = [None] * (len(_CHANNELS) - 1)
    with path.open("w", encoding="utf-8", newline="") as file:
        for _, _, at, host, device, *measured in samples:
            if not recording.samples:
                recording.first_ns = recording.last_ns = at
            zero, last = recording.first_ns, recording.last_ns
            if at - last > step:
                file.write(line((seconds(last - zero + round(interval)), *missing)))
                recording.gaps += 1
            arrival = None if host is None else seconds(host - zero)
            file.write(line((seconds(at - zero), *measured, device, arrival)))
            recording.last_ns = at
            recording.samples += 1
            recording.has_field = recording.has_field or measured[6:] != _NO_FIELD


def _write_channels(recording: Recording, part: str | None, path: Path) -> None:
    rows = []
    for name, component, kind, unit, meaning in _CHANNELS:
        unmeasured = kind == "MAGN" and not recording.has_field
        point, place = _PLACES[part or "hand"] if component else (None, None)
        status = ("bad", "Not measured by this sensor.") if unmeasured else (None, None)
        frame = "sensor" if component else None
        rows.append((name, component, kind, point, unit, place, frame, meaning, *status))
    write_rows(path, _HEAD, rows)


def _about(recording: Recording, stream: Row) -> dict[str, Any]:
    """Return what is known of a recording."""
    lasted = (recording.last_ns - recording.first_ns) / 1e9
    effective = (recording.samples - 1) / lasted if lasted > 0 else None
    counts = {f"{kind}ChannelCount": 3 for kind in _TYPES.values()}
    absent = {f"{kind}ChannelCount": 0 for kind in ("ANGACCEL", "JNTANG", "ORNT", "POS", "VEL")}
    return {
        "SamplingFrequency": stream["rate_hz"] or effective or 0,
        **({} if effective is None else {"SamplingFrequencyEffective": effective}),
        "RecordingDuration": lasted,
        "ManufacturersModelName": stream["model"] or "n/a",
        "TrackingSystemName": stream["model"] or "n/a",
        "TrackedPointsCount": 1,
        "MotionChannelCount": len(_CHANNELS),
        **counts,
        "LATENCYChannelCount": 1,
        "MISCChannelCount": 2,
        **absent,
        "MissingValues": _MISSING_VALUES,
        "GapCount": recording.gaps,
        **{
            name: stream[column]
            for name, column in (
                ("AngularRateRangeInRadPerSecond", "rate_range_rad_s"),
                ("AccelerationRangeInMetersPerSecondSquared", "acceleration_range_m_s2"),
            )
            if stream[column]
        },
    }

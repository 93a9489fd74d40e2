"""``sar-tui sensors``: which motion sensors are seen here, and whether one is fit for a task."""

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from sar_tui.cli.common import AsJson, Home, console, named_path, print_json
from sar_tui.cli.errors import Refused
from sar_tui.model.units import MS, SECOND
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    from sar_tui.app.sensor_monitor import SensorWatch
    from sar_tui.motion.samples import Samples

LOOK = 20 * MS
"""Time between two looks for samples."""
PATIENCE = 10 * SECOND
"""Longest wait for a sensor; and for the hand to rest."""
REST = 5 * SECOND
"""Time at rest that is measured."""
LIFT = 8 * SECOND
"""Longest wait for the hand to be lifted and laid down."""
LOOK_S = 1.0
"""Time to look for streams of LSL."""

GOOD_RATE_HZ = 100.0
LARGE_NOISE_RAD_S = 0.02
"""A fifth of the threshold of the fixed-threshold detector."""
_MOVING_RAD_S = 0.3
_LEAST_LIFT_DEG = 15.0

_FLAT = "Lay the hand flat on the table, palm down, and keep it still."
_LIFT = "Now lift the fingers, with the wrist on the table, and lay them down again."
_TO_NAME = (
    "phidget://HOST:PORT", "phyphox://HOST[:PORT]", "udp://[HOST]:PORT", "ros://HOST[:PORT]/TOPIC",
    "recorded:FILE", "simulated",
)  # fmt: skip
_WRONG_AXIS = {
    "-x": "It points to the wrist: turn it round, so that y points along the fingers.",
    "+y": "It lies across the hand: turn it by a quarter, so that y points along the fingers.",
    "-y": "It lies across the hand: turn it by a quarter, so that y points along the fingers.",
    "+z": "The hand turned flat on the table, or z does not point out of the back of the hand.",
    "-z": "The hand turned flat on the table, or z does not point out of the back of the hand.",
}

Pause = Callable[[int], None]
Verdict = Literal["fit", "with care", "not fit"]


@dataclass(frozen=True)
class Seen:
    """A sensor that is seen here. ``source``: its name for ``--imu``; empty if there is none."""

    source: str
    what: str


@dataclass(kw_only=True)
class Examined:
    """Result of an examination.

    ``lost``: samples that never arrived; ``dropped``: those that could not be used. Noise is the
    standard deviation at rest, over the three axes; None if the hand did not rest. ``lifted``: the
    axis about which the hand turned when its fingers were lifted, and by how much.
    """

    source: str
    model: str = ""
    serial: str = ""
    rate_hz: float | None = None
    nominal_hz: float | None = None
    received: int = 0
    lost: int = 0
    dropped: int = 0
    saturated: int = 0
    bias_rad_s: float | None = None
    noise_rad_s: float | None = None
    noise_m_s2: float | None = None
    lifted: str = ""
    lifted_deg: float | None = None
    verdict: Verdict = "fit"
    problems: list[str] = field(default_factory=list)

    def mind(self, problem: str, verdict: Verdict = "with care") -> None:
        """Note a problem; the verdict is never better than before."""
        self.problems.append(problem)
        if self.verdict != "not fit":
            self.verdict = verdict


def sensors(
    home: Home,
    source: Annotated[
        str | None,
        typer.Argument(
            metavar="[SOURCE]", help="A sensor to examine, as for --imu.", show_default=False
        ),
    ] = None,
    at_rest: Annotated[
        bool, typer.Option("--at-rest", help="Examine it at rest only, without a movement.")
    ] = False,
    phyphox: Annotated[
        Path | None,
        typer.Option(
            "--phyphox",
            parser=named_path,
            metavar="FILE.phyphox",
            show_default=False,
            help="Write the experiment for the app phyphox, with both sensors of the phone.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List the motion sensors that are seen here, or examine one: rate, lost samples, noise, axes.

    Exit code 1 if the sensor is not fit for the reaching task.
    """
    if phyphox:
        if source:
            raise Refused("--phyphox goes without a sensor: sar-tui sensors --phyphox FILE.")
        _write_experiment(phyphox)
    elif source is None:
        _list(as_json)
    else:
        _examine(source, at_rest, as_json)


def _write_experiment(path: Path) -> None:
    from sar_tui.inputs.phyphox import experiment_file

    try:
        with path.open("xb") as file:
            file.write(experiment_file())
    except FileExistsError:
        raise Refused(
            f"{path} exists already, and is not overwritten. Name another file."
        ) from None
    except OSError as error:
        raise Refused(f"{path} cannot be written: {error.strerror}.") from error
    print(f"{path}: send it to the phone, and open it with phyphox.")


# --- what is seen


def _list(as_json: bool) -> None:
    seen = [*_phidgets(), *_serial_ports(), *_streams(), *_plug_ins()]
    if as_json:
        found = [each for each in seen if each.source]
        print_json({"seen": found, "to_name": _TO_NAME})
        return
    out = console()
    for each in seen:
        out.print(f"{each.source or '–':24} {each.what}", soft_wrap=True)
    out.print(f"Those that cannot be looked for: {', '.join(_TO_NAME)}.", soft_wrap=True)
    out.print("`sar-tui sensors SOURCE` examines one.")


def _phidgets() -> Iterator[Seen]:
    from sar_tui.cli.doctor.devices import motion_sensor

    found = motion_sensor()
    is_there = found.state == "ok" and "serial" in found.found
    yield Seen("phidget" if is_there else "", f"PhidgetSpatial: {found.found}")


def _serial_ports() -> Iterator[Seen]:
    try:
        from serial.tools.list_ports import comports
    except ImportError:
        yield Seen("", "Serial ports: the package for them is not installed.")
        return
    ports = sorted(comports(), key=lambda port: str(port.device))
    for port in ports:
        yield Seen(f"serial://{port.device}", f"serial port: {port.description}")
    if not ports:
        yield Seen("", "Serial ports: none.")


def _streams() -> Iterator[Seen]:
    from sar_tui.drivers.lsl import NoLibrary, library

    try:
        pylsl = library()
    except NoLibrary:
        yield Seen("", "LSL streams: the package for them is not installed.")
        return
    streams = [each for each in pylsl.resolve_streams(LOOK_S) if each.type() != "Markers"]
    for each in streams:
        what = f"LSL stream, type {each.type()}, {each.nominal_srate():g} samples a second"
        yield Seen(f"lsl://{each.name()}", what)
    if not streams:
        yield Seen("", "LSL streams: none.")


def _plug_ins() -> Iterator[Seen]:
    from sar_tui.inputs.sources import plug_in_names

    for name in plug_in_names():
        yield Seen(name, "sensor of a plug-in")


# --- one sensor


def _examine(source: str, at_rest: bool, as_json: bool) -> None:
    from sar_tui.app.sensor_monitor import SensorWatch
    from sar_tui.inputs.imu import SourceError
    from sar_tui.inputs.imu_feed import ImuFeed
    from sar_tui.inputs.sources import open_source
    from sar_tui.loop.clock import host_now

    try:
        feed = ImuFeed(open_source(source), host_now)
    except SourceError as error:
        raise Refused(str(error)) from error
    watch = SensorWatch(feed, host_now, "right")
    tell = console(error=True)
    feed.start()
    try:
        found = examine(
            source, watch, lambda ns: time.sleep(ns / SECOND), tell.print, at_rest=at_rest
        )
    finally:
        feed.stop()
    if as_json:
        print_json(found)
    else:
        _print(found)
    if found.verdict == "not fit":
        raise typer.Exit(FAILED)


def examine(
    source: str,
    watch: "SensorWatch",
    pause: Pause,
    say: Callable[[str], None],
    *,
    at_rest: bool = False,
) -> Examined:
    """Examine a sensor: at rest, and while the fingers are lifted.

    Args:
        source: its name.
        watch: watches its feed, which has been started.
        pause: waits for a time in ns.
        say: shows a line to the person.
        at_rest: True to leave the movement out.
    """
    found = Examined(source=source)
    if not _attach(watch, pause):
        found.mind(watch.detail or "There is no sensor.", "not fit")
        return found
    info = watch.feed.info
    if info:
        found.model, found.serial, found.nominal_hz = info.model, info.serial, info.rate_hz
    say(_FLAT)
    _rest(found, watch, pause)
    is_simulated = hasattr(watch.feed.source, "move")
    if not (at_rest or is_simulated or watch.state != "attached" or watch.too_slow):
        say(_LIFT)
        _lift(found, watch, pause)
    _judge(found, watch)
    return found


def _attach(watch: "SensorWatch", pause: Pause) -> bool:
    """Wait for the sensor; return True if there is one."""
    while watch.state != "attached" and watch.waited < PATIENCE:
        pause(LOOK)
        watch.look()
    return watch.state == "attached"


def _rest(found: Examined, watch: "SensorWatch", pause: Pause) -> None:
    """Measure rate and noise while the hand rests."""
    import numpy as np

    from sar_tui.motion.samples import join

    blocks, until = [], watch.waited + PATIENCE
    while watch.attached and watch.waited < until and (watch.still_s or 0.0) * SECOND < REST:
        pause(LOOK)
        blocks.append(watch.look())
    found.rate_hz = round(watch.feed.rate_hz, 1)
    samples = join([block for block in blocks if len(block)])
    if watch.still_s and len(samples) > 1:
        still = samples[samples["at"] > samples["at"][-1] - watch.still_s * SECOND]
        rate = still["rate"].astype(float)
        found.bias_rad_s = round(float(np.linalg.norm(rate.mean(axis=0))), 5)
        found.noise_rad_s = round(float(np.linalg.norm(rate.std(axis=0))), 5)
        noise = float(np.linalg.norm(still["acceleration"].astype(float).std(axis=0)))
        found.noise_m_s2 = None if math.isnan(noise) else round(noise, 4)


def _lift(found: Examined, watch: "SensorWatch", pause: Pause) -> None:
    """Find the axis about which the hand turns when its fingers are lifted."""
    from sar_tui.motion.samples import join

    bias, begun, blocks, has_moved = watch.bias, watch.waited, [], False
    while watch.attached and watch.waited - begun < LIFT:
        pause(LOOK)
        blocks.append(watch.look())
        has_moved = has_moved or watch.still_s == 0.0
        if has_moved and (watch.still_s or 0.0) >= 1.0:
            break
    axis, degrees = turned(join([block for block in blocks if len(block)]), bias)
    found.lifted_deg = round(degrees, 1)
    if degrees >= _LEAST_LIFT_DEG:
        found.lifted = axis


def turned(samples: "Samples", bias: tuple[float, float, float] | None) -> tuple[str, float]:
    """Return the axis about which the hand first turned farthest, such as ``+x``, and the angle in
    degrees.
    """
    import numpy as np

    if len(samples) < 2:
        return "", 0.0
    rate = samples["rate"].astype(float) - np.array(bias or (0.0, 0.0, 0.0))
    moving = np.flatnonzero(np.linalg.norm(rate, axis=1) > _MOVING_RAD_S)
    if not len(moving):
        return "", 0.0
    steps_s = np.diff(samples["at"], prepend=samples["at"][0]) / 1e9
    angle = np.cumsum((rate * steps_s[:, None])[moving[0] :], axis=0)
    farthest = angle[np.linalg.norm(angle, axis=1).argmax()]
    axis = int(np.abs(farthest).argmax())
    sign = "+" if farthest[axis] > 0 else "-"
    return f"{sign}{'xyz'[axis]}", float(np.degrees(np.linalg.norm(farthest)))


def _judge(found: Examined, watch: "SensorWatch") -> None:
    """Add the counts, the problems and the verdict for the reaching task."""
    from sar_tui.app.sensor_advice import ENOUGH, FEW_LOST, LARGE_BIAS_RAD_S
    from sar_tui.inputs.recording_file import LOWEST_RATE_HZ

    feed = watch.feed
    found.received, found.dropped = feed.received, feed.dropped
    found.lost = max(0, feed.lost - watch.unmeasured)
    found.saturated = watch.saturated
    rate_hz, nominal_hz = found.rate_hz or 0.0, found.nominal_hz or 0.0
    if not watch.attached or watch.stalled or not feed.received:
        found.mind(watch.detail or "It stopped sending.", "not fit")
    elif watch.too_slow or rate_hz < LOWEST_RATE_HZ:
        found.mind("It sends too few samples a second to see a reach.", "not fit")
    elif rate_hz < GOOD_RATE_HZ:
        found.mind("It sends fewer than 100 samples a second: times are less exact.")
    elif rate_hz < ENOUGH * nominal_hz:
        found.mind("It sends fewer samples a second than it should.")
    if found.lost + found.dropped > FEW_LOST * max(1, feed.received):
        found.mind(
            "More than 1 % of its samples are missing: try another cable, port or network.",
            "not fit",
        )
    if found.noise_rad_s is None and feed.received:
        found.mind("The hand did not rest, so noise and bias were not measured.")
    elif found.noise_rad_s and found.noise_rad_s > LARGE_NOISE_RAD_S:
        found.mind("It is noisy at rest: was the hand still?")
    if (found.bias_rad_s or 0.0) > LARGE_BIAS_RAD_S:
        found.mind("Its bias is large: the fixed-threshold detector does not work with it.")
    if found.lifted_deg is not None and not found.lifted:
        found.mind("The fingers were not lifted, so its axes were not checked.")
    if wrong := _WRONG_AXIS.get(found.lifted):
        found.mind(wrong)
    if watch.trouble:
        found.mind(watch.trouble)


def _print(found: Examined) -> None:
    out = console()

    def line(title: str, *parts: str) -> None:
        out.print(f"{title:8} {', '.join(filter(None, parts))}", soft_wrap=True)

    if found.model:
        line("Sensor", found.model, f"serial {found.serial}" if found.serial else "")
        saturated = f"{found.saturated} beyond its range" if found.saturated else ""
        nominal = f" of {found.nominal_hz:.0f}" if found.nominal_hz else ""
        line(
            "Samples",
            f"{found.rate_hz or 0:.0f} a second{nominal}",
            f"{found.lost} of {found.received + found.lost} lost",
            f"{found.dropped} left out" if found.dropped else "",
            saturated,
        )
    if found.noise_rad_s is not None:
        acceleration = "" if found.noise_m_s2 is None else f"{found.noise_m_s2:.3f} m/s²"
        noise = f"noise {found.noise_rad_s:.4f} rad/s"
        line("At rest", noise, acceleration, f"bias {found.bias_rad_s:.4f} rad/s")
    if found.lifted:
        line("Lifted", f"{found.lifted_deg:.0f}° about {found.lifted}")
    for problem in found.problems:
        line("!", problem)
    line("Verdict", f"{found.verdict} for the reaching task")

"""``sar-tui sensors``: which motion sensors are seen here, and whether one is fit for a task."""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated
from urllib.parse import quote

import typer

from sar_tui.cli.common import AsJson, Home, console, named_path, print_json
from sar_tui.cli.errors import Refused
from sar_tui.model.units import SECOND
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    from sar_tui.app.sensor_examination import Examined

LOOK_S = 1.0
"""Time to look for streams of LSL."""
_TO_NAME = (
    "phidget://HOST:PORT", "phyphox://HOST[:PORT]", "udp://[HOST]:PORT", "ros://HOST[:PORT]/TOPIC",
    "recorded:FILE", "simulated",
)  # fmt: skip
_VERDICTS = {
    "fit": "fit for the reaching task",
    "with care": "fit for the reaching task, with the limits above",
    "not fit": "not fit for the reaching task",
}


@dataclass(frozen=True)
class Seen:
    """A sensor that is seen here. ``source``: its name for ``--imu``; empty if there is none."""

    source: str
    what: str


def sensors(
    home: Home,
    source: Annotated[
        str | None,
        typer.Argument(metavar="[SOURCE]", help="A sensor to examine, as for --imu."),
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
    out.print(f"Other sensors are not looked for: {', '.join(_TO_NAME)}.", soft_wrap=True)
    out.print("`sar-tui sensors SOURCE` examines one, seen or not.")


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
        described = "" if port.description in (None, "n/a") else f": {port.description}"
        yield Seen(f"serial://{port.device}", f"serial port{described}")
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
        yield Seen(f"lsl://{quote(each.name())}", what)
    if not streams:
        yield Seen("", "LSL streams: none.")


def _plug_ins() -> Iterator[Seen]:
    from sar_tui.inputs.sources import plug_in_names

    for name in plug_in_names():
        yield Seen(name, "sensor of a plug-in")


# --- one sensor


def _examine(source: str, at_rest: bool, as_json: bool) -> None:
    from sar_tui.app.sensor_examination import examine
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


def _print(found: "Examined") -> None:
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
    line("Verdict", _VERDICTS[found.verdict])

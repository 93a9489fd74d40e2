"""``sar-tui sensors``: what is seen, and whether a sensor is fit, for people and programs."""

import sys
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from sar_tui.app import sensor_examination
from sar_tui.app.sensor_examination import Examined, examine
from sar_tui.app.sensor_monitor import SensorWatch
from sar_tui.inputs.imu import ImuSource
from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.inputs.lsl import LslSource
from sar_tui.inputs.phyphox import experiment_file
from sar_tui.inputs.recorded import RecordedSource
from sar_tui.inputs.sources import open_source
from sar_tui.loop.clock import VirtualClock
from sar_tui.model.units import MS, SECOND
from sar_tui.motion.samples import SAMPLE, Samples
from tests.program import Call

Patch = pytest.MonkeyPatch


def lifted(
    axis: str = "+x",
    *,
    rate_hz: float = 200.0,
    noise: float = 0.002,
    bias: float = 0.0,
    keep: Callable[[int], bool] = lambda n: True,
    acceleration: float = 9.81,
    turning: float = np.pi / 4,
) -> Samples:
    """Return samples of a hand that rests for seven seconds, lifts its fingers and lays them
    down.
    """
    t = np.arange(0, 25, 1 / rate_hz)
    samples = np.zeros(len(t), dtype=SAMPLE)
    samples["at"] = samples["host"] = np.round(t * 1e9)
    samples["device_ms"] = t * 1000
    random = np.random.default_rng(1)
    samples["rate"] = random.normal(bias, noise, (len(t), 3))
    samples["acceleration"][:, 2] = acceleration
    samples["field"] = np.nan
    moving = (t > 7) & (t < 9)
    wave = turning * np.sin((t[moving] - 7) * np.pi)  # out by 28.6°, and back
    samples["rate"][moving, "xyz".index(axis[1])] += (1 if axis[0] == "+" else -1) * wave
    return samples[[keep(n) for n in range(len(t))]]


def examined(make: Callable[[VirtualClock], ImuSource], **how: Any) -> Examined:
    clock = VirtualClock()
    feed = ImuFeed(make(clock), clock.now)
    watch = SensorWatch(feed, clock.now, "right")
    feed.start()
    return examine("it", watch, clock.advance, lambda text: None, **how)


def played(samples: Samples, **how: Any) -> Examined:
    return examined(lambda clock: RecordedSource(samples, clock=clock), **how)


def test_a_good_sensor_is_fit() -> None:
    found = played(lifted())
    assert (found.verdict, found.problems) == ("fit", [])
    assert found.rate_hz == pytest.approx(200, abs=2)
    assert found.nominal_hz == pytest.approx(200)
    assert (found.lost, found.dropped, found.saturated) == (0, 0, 0)
    assert found.noise_rad_s == pytest.approx(0.002 * 3**0.5, rel=0.1)
    assert found.noise_m_s2 == 0.0
    assert found.lifted == "+x"
    assert found.lifted_deg == pytest.approx(28.6, abs=1)


@pytest.mark.parametrize(
    ("samples", "verdict", "said"),
    [
        (lifted("-x"), "with care", "It points to the wrist"),
        (lifted("+y"), "with care", "It lies across the hand"),
        (lifted("-z"), "with care", "turned flat on the table"),
        (lifted(noise=0.03), "with care", "It is noisy at rest"),
        (lifted(bias=0.05), "with care", "Its bias is large"),
        (lifted(rate_hz=50), "with care", "fewer than 100 samples"),
        (lifted(rate_hz=15), "not fit", "too few samples a second"),
        (lifted(keep=lambda n: n % 20 > 0), "not fit", "More than 1 % of its samples are missing"),
        (lifted(acceleration=-9.81), "with care", "z does not point up: the sensor is turned over"),
        (lifted(acceleration=1.0), "with care", "At rest it measures 1.0 m/s² in place of 9.8"),
        (lifted(turning=45.0), "not fit", "seems to send deg/s"),
    ],
)
def test_a_problem_is_said_and_counts(samples: Samples, verdict: str, said: str) -> None:
    found = played(samples)
    assert found.verdict == verdict
    assert said in " ".join(found.problems)


def test_a_sensor_that_is_turned_over_is_not_said_to_point_to_the_wrist() -> None:
    (problem,) = played(lifted("-x", acceleration=-9.81)).problems
    assert "turned over" in problem


def test_a_sensor_that_is_gone_is_told_by_that_alone() -> None:
    ended = played(lifted()[:600])
    assert ended.problems == ["The recording is at its end."]


def test_a_movement_that_is_not_made_is_said_and_may_be_left_out() -> None:
    still = lifted()
    still["rate"] = 0.0
    (problem,) = played(still).problems
    assert problem.startswith("The fingers were not lifted, so its axes were not checked")
    assert played(still, at_rest=True).problems == []


def test_a_hand_that_never_rests_and_a_simulated_one_are_examined() -> None:
    restless = lifted()
    restless["rate"][:, 0] += np.sin(restless["at"] / 1e8)
    found = played(restless)
    assert "The hand did not rest, so noise and bias were not measured." in found.problems
    assert examined(lambda clock: open_source("simulated", clock=clock)).verdict == "fit"


def test_a_sensor_that_is_missing_or_ends_is_not_fit(call: Call, monkeypatch: Patch) -> None:
    ended = played(lifted()[:900])
    assert (ended.verdict, ended.problems[0]) == ("not fit", "The recording is at its end.")
    monkeypatch.setattr(sensor_examination, "WAIT", 1200 * MS)
    done = call("sensors serial:///dev/nowhere --json")
    assert done.code == 1
    waiting = "Waiting for the serial port /dev/nowhere: plug the board in."
    assert done.json["problems"] == [f"No sensor was found. {waiting}"]
    assert waiting in done.err, "it is said while it is waited for"
    assert set(done.json) == {field.name for field in fields(Examined)}


def test_a_sensor_is_examined_for_people(call: Call, monkeypatch: Patch) -> None:
    monkeypatch.setattr(sensor_examination, "REST", SECOND // 5)
    done = call("sensors simulated")
    assert done.code == 0
    for said in ("Sensor   Simulated hand", " a second of 250, 0 of ", "fit for the reaching task"):
        assert said in done.out
    assert "Lay the hand flat" in done.err


def test_limits_of_a_sensor_are_told_in_the_verdict(call: Call, monkeypatch: Patch) -> None:
    monkeypatch.setattr(sensor_examination, "REST", SECOND // 5)
    done = call("sensors simulated:biased")
    assert (done.code, "fit for the reaching task, with the limits above" in done.out) == (0, True)


def test_the_experiment_for_phyphox_is_written_once(call: Call, tmp_path: Path) -> None:
    path = tmp_path / "sar-tui.phyphox"
    call("sensors --phyphox", path).shows("send it to the phone")
    assert path.read_bytes() == experiment_file()
    call("sensors --phyphox", path).refused("exists already")
    call("sensors --phyphox", tmp_path / "no" / "x.phyphox").refused("cannot be written")
    call("sensors simulated --phyphox", path).refused("goes without a sensor")


class Streams(ModuleType):
    """LSL with two streams, of which one has markers."""

    def resolve_streams(self, _: float) -> list[Any]:
        def stream(name: str, kind: str) -> Any:
            facts = {"name": name, "type": kind, "nominal_srate": 100.0}
            return SimpleNamespace(**{n: lambda v=v: v for n, v in facts.items()})

        return [stream("my wrist?", "IMU"), stream("sar-tui", "Markers")]


@pytest.mark.usefixtures("_streams")
def test_what_is_seen_is_listed_for_people_and_programs(call: Call, monkeypatch: Patch) -> None:
    pytest.importorskip("serial")
    port = SimpleNamespace(device="/dev/ttyUSB0", description="Arduino")
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: [port])
    printed = call("sensors --json").json
    assert set(printed) == {"seen", "to_name"}
    assert [each["source"] for each in printed["seen"]][-2:] == [
        "serial:///dev/ttyUSB0",
        "lsl://my%20wrist%3F",
    ]
    assert LslSource("//my%20wrist%3F")._stream == "my wrist?"
    assert "phyphox://HOST[:PORT]" in printed["to_name"]
    call("sensors").shows("serial:///dev/ttyUSB0", "Arduino", "lsl://my%20wrist", "type IMU")


@pytest.fixture
def _streams(monkeypatch: Patch) -> None:
    monkeypatch.setattr("sar_tui.drivers.lsl.library", lambda: Streams("pylsl"))


def test_missing_packages_are_no_fault(call: Call, monkeypatch: Patch) -> None:
    for name in ("serial", "serial.tools", "serial.tools.list_ports", "pylsl"):
        monkeypatch.setitem(sys.modules, name, None)
    call("sensors").shows("Serial ports: the package", "LSL streams: the package")

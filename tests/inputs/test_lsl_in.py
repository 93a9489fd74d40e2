"""A stream of LSL as a source: from a real outlet, and what its channels are."""

import os
import time
import uuid
from collections.abc import Iterable, Sequence
from itertools import pairwise
from random import Random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.inputs import delivery, lsl
from sar_tui.inputs.delivery import Unusable
from sar_tui.inputs.imu import DEGREE, G, Sample, SourceError, Status
from sar_tui.inputs.lsl import Columns, EvenStamps, LslSource, _Options
from tests.fake_rosbridge import wait_until
from tests.outputs.markers.receivers import UdpReceiver

LABELS = ("AccX", "AccY", "AccZ", "GyroX", "GyroY", "GyroZ")
DEGREES = ("g", "g", "g", "deg/s", "deg/s", "deg/s")


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(delivery, "RETRY_S", 0.01)


def outlet(
    name: str,
    labels: Sequence[str] = LABELS,
    units: Sequence[str] = DEGREES,
    rate_hz: float = 200.0,
) -> Any:
    """Return an outlet of a stream, or skip the test if streams cannot be found here."""
    pylsl = pytest.importorskip("pylsl")
    UdpReceiver().close()
    info = pylsl.StreamInfo(name, "IMU", len(labels), rate_hz, pylsl.cf_float32, name)
    channels = info.desc().append_child("channels")
    for label, unit in zip(labels, units, strict=True):
        channel = channels.append_child("channel")
        channel.append_child_value("label", label)
        channel.append_child_value("unit", unit)
    return pylsl.StreamOutlet(info)


def need_streams(name: str) -> None:
    """Skip the test if LSL finds no stream on this machine."""
    import pylsl

    required = os.environ.get("SAR_TUI_TEST_LSL") == "required"
    if not pylsl.resolve_byprop("name", name, 1, 60.0 if required else 10.0):
        assert not required
        pytest.skip("LSL finds no stream on this machine: it has no loopback network")


@pytest.mark.parametrize("is_lost", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_samples_of_a_stream_come_with_its_stamps_also_when_it_was_lost(
    monkeypatch: pytest.MonkeyPatch, is_lost: bool
) -> None:
    name = f"sar-tui-test-{uuid.uuid4().hex[:8]}"
    stream = outlet(name)
    need_streams(name)
    monkeypatch.setattr(lsl, "LOOK_S", 5.0)
    source, samples, statuses = LslSource(f"//{name}"), list[Sample](), list[Status]()
    source.start(samples.append, statuses.append)

    def states() -> list[str]:
        return [status.state for status in list(statuses)]

    def play(stream: Any, times: int) -> None:
        """Send samples, and see them arrive."""
        wait_until(stream.have_consumers)
        began = len(samples)
        for number in range(100):
            stream.push_sample([0.0, 0.0, 1.0, 90.0, 0.0, number], 1000 + number / 200)
        wait_until(lambda: len(samples) == began + 100)
        expected = [5.0 * number for number in range(100)]
        assert [each.device_ms for each in samples[began:]] == pytest.approx(expected)
        assert samples[began].rate == pytest.approx((90 * DEGREE, 0.0, 0.0))
        assert samples[began].acceleration == pytest.approx((0.0, 0.0, G))
        assert source.info is not None
        assert source.info.rate_hz == pytest.approx(200)
        assert states().count("attached") == times

    play(stream, 1)
    if is_lost:
        del stream
        wait_until(lambda: states()[-1] == "detached")
        assert statuses[-1].detail.startswith(f"Waiting for the LSL stream {name}")
        play(outlet(name), 2)
        assert "error" not in states()
    source.stop()


def test_a_sample_is_delivered_when_it_comes(monkeypatch: pytest.MonkeyPatch) -> None:
    name = f"sar-tui-test-{uuid.uuid4().hex[:8]}"
    stream = outlet(name)
    need_streams(name)
    monkeypatch.setattr(lsl, "LOOK_S", 5.0)
    monkeypatch.setattr(lsl, "_PULL_S", 2.0)
    monkeypatch.setattr(delivery, "LOOKED_AT", 5)
    monkeypatch.setattr(delivery, "CLOSE_S", 20.0)
    source, samples = LslSource(f"//{name}"), list[Sample]()
    source.start(samples.append, lambda status: None)
    wait_until(stream.have_consumers)
    for number in range(10):
        stream.push_sample([0.0, 0.0, 1.0, 0.0, 0.0, number], 1000 + number / 200)
    wait_until(lambda: len(samples) == 10)
    began = time.monotonic()
    stream.push_sample([0.0, 0.0, 1.0, 0.0, 0.0, 0.0], 1000.05)
    wait_until(lambda: len(samples) == 11)
    assert time.monotonic() - began < 1.5
    del stream
    source.stop()


# --- stamps of a sender


INTERVAL_MS = 5.0


def evened(stamps_ms: Iterable[float], rate_hz: float = 200.0) -> list[float]:
    even = EvenStamps(rate_hz)
    return [even.ms(1000 + stamp_ms / 1000) for stamp_ms in stamps_ms]


def in_chunks(size: int, most_ms: float, interval_ms: float = INTERVAL_MS) -> list[float]:
    """Return stamps of a sender that stamps each chunk when it arrives: late by up to a time."""
    random, stamps = Random(5), list[float]()
    for first in range(0, 3000, size):
        late_ms = random.uniform(0.0, most_ms)
        stamps += [n * interval_ms + late_ms for n in range(first, first + size)]
    return stamps


@pytest.mark.parametrize("interval_ms", [INTERVAL_MS, 0.99 * INTERVAL_MS, 1.01 * INTERVAL_MS])
def test_chunks_that_arrive_early_and_late_become_even(interval_ms: float) -> None:
    stamps = in_chunks(10, 15.0, interval_ms)
    assert min(b - a for a, b in pairwise(stamps)) < 0, "they go back"
    steps = [b - a for a, b in pairwise(evened(stamps))]
    assert 0.5 * INTERVAL_MS < min(steps) <= max(steps) < 1.5 * INTERVAL_MS
    error_ms = [even - n * interval_ms for n, even in enumerate(evened(stamps))]
    assert max(error_ms) - min(error_ms) < 15.0


def test_stamps_of_the_sensor_itself_stay_and_missing_samples_are_seen() -> None:
    stamps = [n * INTERVAL_MS for n in range(1500) if not 700 <= n < 707]
    for rate_hz in (200.0, 0.0):
        assert evened(stamps, rate_hz) == pytest.approx(stamps)
    restarted = [*stamps, *stamps]
    assert evened(restarted)[len(stamps)] == pytest.approx(0.0)


@given(st.lists(st.floats(0, 1e6)))
def test_a_stream_without_a_nominal_rate_keeps_its_stamps(stamps: list[float]) -> None:
    first = stamps[0] if stamps else 0.0
    assert evened(stamps, 0.0) == pytest.approx([each - first for each in stamps], abs=1e-6)


@pytest.mark.parametrize(
    "labels",
    [
        LABELS,
        ("acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"),
        ("ax", "ay", "az", "wx", "wy", "wz"),
        tuple(f"{kind} {axis}" for kind in ("Acceleration", "Gyroscope") for axis in "XYZ"),
    ],
)
def test_channels_are_known_by_their_labels(labels: Sequence[str]) -> None:
    columns = Columns("s", labels, DEGREES, _Options())
    acceleration, rate = columns.read([0, 0, 1, 0, 0, 180])
    assert acceleration == pytest.approx((0, 0, G))
    assert rate == pytest.approx((0, 0, 180 * DEGREE))


def test_the_name_of_the_sensor_may_say_what_the_stream_does_not() -> None:
    options = _Options(columns="count,wx,wy,wz", rate="rad/s")
    columns = Columns("s", [""] * 5, [""] * 5, options)
    acceleration, rate = columns.read([9, 1, 2, 3, 9])
    assert rate == (1.0, 2.0, 3.0)
    assert acceleration[0] != acceleration[0]


@pytest.mark.parametrize(
    ("labels", "units", "said"),
    [
        (("a", "b", "c"), ("", "", ""), "their labels are a, b, c. Name them in order"),
        (("", "", ""), ("", "", ""), "their labels are missing"),
        (("wx", "wy", "wz"), ("", "", ""), "does not say the unit of its angular rate"),
        (LABELS, ("", "", "", "rad/s", "", ""), "does not say the unit of its acceleration"),
    ],
)
def test_a_stream_that_says_too_little_is_refused(
    labels: Sequence[str], units: Sequence[str], said: str
) -> None:
    with pytest.raises(Unusable, match=said):
        Columns("s", labels, units, _Options())


@pytest.mark.parametrize("address", ["", "//", "//a'b", "//imu?rate=rpm", "//imu?hz=5"])
def test_an_invalid_address_is_refused_with_an_example(address: str) -> None:
    with pytest.raises(SourceError, match="Use lsl://NAME"):
        LslSource(address)

"""A stream of LSL as a source: from a real outlet, and what its channels are."""

import os
import uuid
from collections.abc import Sequence
from typing import Any

import pytest

from sar_tui.inputs import delivery, lsl
from sar_tui.inputs.delivery import Unusable
from sar_tui.inputs.imu import DEGREE, G, Sample, SourceError, Status
from sar_tui.inputs.lsl import Columns, LslSource, _Options
from tests.fake_rosbridge import wait_until
from tests.outputs.markers.receivers import UdpReceiver

LABELS = ("AccX", "AccY", "AccZ", "GyroX", "GyroY", "GyroZ")
DEGREES = ("g", "g", "g", "deg/s", "deg/s", "deg/s")


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(delivery, "RETRY_S", 0.01)


def outlet(name: str, labels: Sequence[str] = LABELS, units: Sequence[str] = DEGREES) -> Any:
    """Return an outlet of a stream, or skip the test if streams cannot be found here."""
    pylsl = pytest.importorskip("pylsl")
    UdpReceiver().close()
    info = pylsl.StreamInfo(name, "IMU", len(labels), 200.0, pylsl.cf_float32, name)
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
        play(outlet(name), 2)
    source.stop()


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

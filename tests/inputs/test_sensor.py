"""The motion sensor on the bus: samples and statuses in order."""

from typing import Any

import numpy as np
import pytest

from sar_tui.inputs.imu import Info, Sample, Status
from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.inputs.sensor import DRAIN, Imu
from sar_tui.loop.bus import Bus, Record
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.topics import IMU, SENSOR
from sar_tui.model.messages import ImuBlock, SensorChanged
from sar_tui.model.units import MS
from sar_tui.motion.samples import unpack
from tests.inputs.test_imu_feed import INFO, ByHand


class Bench:
    """A sensor that a test controls, and a bus with a listener."""

    def __init__(self, *, looked_at: bool = False) -> None:
        self.clock = VirtualClock(1000 * MS)
        self.source = ByHand()
        self.feed = ImuFeed(self.source, self.clock.now)
        self.bus = Bus(self.clock)
        self.records: list[Record] = []
        self.bus.tap(self.records.extend)
        if looked_at:
            self.feed.start()
            self.report("attached")
        self.node = Imu(self.feed)

    def begin(self) -> None:
        """Begin the session."""
        self.node.attach(self.bus)
        self.wait(0)

    def report(self, state: Any, info: Info = INFO, **facts: Any) -> None:
        if state == "attached":
            self.source.info = info
        elif state == "detached":
            self.source.info = None
        self.source.on_status(Status(state=state, at=self.clock.now(), **facts))

    def send(self, *device_ms: float) -> None:
        for stamp in device_ms:
            self.source.sink(Sample(self.clock.now(), stamp, (0.0, 0.0, 9.8), (0.1, 0.2, 0.3)))

    def wait(self, ms: float) -> None:
        self.clock.advance(round(ms * MS))

    @property
    def published(self) -> list[str | list[float]]:
        """Return the statuses and the sensor's stamps of each block, in order."""
        return [
            unpack(message.samples)["device_ms"].tolist()
            if isinstance(message, ImuBlock)
            else message.state
            for record in self.records
            if isinstance(message := record.message, ImuBlock | SensorChanged)
        ]


@pytest.fixture
def bench() -> Bench:
    made = Bench()
    made.begin()
    made.report("attached")
    made.wait(10)
    return made


def test_a_sensor_is_started_when_the_session_begins_and_not_before() -> None:
    bench = Bench()
    assert not bench.feed.is_running
    bench.node.attach(bench.bus)
    assert not bench.feed.is_running, "the session has not begun; nobody would hear of it"
    bench.wait(0)
    assert bench.feed.is_running

    left = Bench()
    left.node.attach(left.bus)
    left.node.detach()
    left.wait(1000)
    assert not left.feed.is_running, "the session ended before it began"
    assert left.records == []


def test_samples_are_published_in_one_block_every_ten_milliseconds(bench: Bench) -> None:
    assert DRAIN == 10 * MS
    bench.send(0, 4)
    bench.wait(9)
    assert bench.published == ["attached"]
    bench.send(8)
    bench.wait(1)
    assert bench.published == ["attached", [0, 4, 8]]
    bench.wait(10)
    assert bench.published == ["attached", [0, 4, 8]], "nothing came, so nothing is reported"
    bench.send(12)
    bench.wait(10)
    assert bench.published[2:] == [[12]]


def test_a_block_holds_the_samples_as_the_feed_made_them(bench: Bench) -> None:
    bench.send(0)
    bench.wait(10)
    (message,) = [record.message for record in bench.records if record.topic is IMU]
    (sample,) = unpack(message.samples)
    assert (sample["at"], sample["host"], sample["device_ms"]) == (1010 * MS, 1010 * MS, 0.0)
    assert np.allclose(sample["rate"], [0.1, 0.2, 0.3])
    assert np.isnan(sample["field"]).all()


def test_an_attached_sensor_is_described(bench: Bench) -> None:
    (changed,) = [record.message for record in bench.records if record.topic is SENSOR]
    assert changed == SensorChanged(
        state="attached",
        at=1000 * MS,
        source="test",
        model="By hand",
        rate_hz=250.0,
        rate_range_rad_s=5.0,
        acceleration_range_m_s2=80.0,
    )


def test_other_reports_are_passed_on_literally(bench: Bench) -> None:
    bench.report("error", detail="The cable is broken.")
    bench.wait(10)
    assert bench.records[-1].message == SensorChanged(
        state="error", at=1010 * MS, detail="The cable is broken."
    )


def test_reports_are_published_in_order_with_the_samples() -> None:
    bench = Bench()
    bench.begin()
    bench.report("attached")
    bench.send(0, 4)
    bench.report("detached")
    bench.wait(10)
    assert bench.published == ["attached", [0, 4], "detached"]


def test_a_stall_and_its_end_are_reported_before_the_samples(bench: Bench) -> None:
    bench.send(0)
    bench.wait(600)
    assert bench.published[-1] == "stalled"
    bench.send(604)
    bench.wait(10)
    assert bench.published[3:] == ["flowing", [604], "gap"], "a gap after the samples beside it"
    gap = bench.records[-1].message
    assert isinstance(gap, SensorChanged)
    assert (gap.count, gap.duration_ms) == (150, 604.0)


def test_a_detached_node_is_silent_and_releases_the_sensor(bench: Bench) -> None:
    bench.node.detach()
    assert (bench.source.stopped, bench.feed.is_running) == (1, False)
    bench.send(0)
    bench.wait(1000)
    assert bench.published == ["attached"]
    bench.node.detach()
    assert not bench.feed.is_running


# --- a sensor that has been looked at before


def test_a_running_sensor_is_taken_over_without_a_restart() -> None:
    bench = Bench(looked_at=True)
    bench.send(0, 4)
    received = bench.feed.drain().samples
    assert len(received) == 2
    bench.send(8)
    bench.begin()
    assert bench.feed.received == 3, "its counts go on, and samples from before are discarded"
    assert bench.published == ["attached"]
    changed = bench.records[0].message
    assert isinstance(changed, SensorChanged)
    assert (changed.model, changed.rate_hz, changed.at) == ("By hand", 250.0, bench.clock.now())
    bench.send(12)
    bench.wait(10)
    assert bench.published == ["attached", [12]]


@pytest.mark.parametrize("was_attached", [True, False])
def test_a_sensor_found_during_the_session_is_reported(was_attached: bool) -> None:
    bench = Bench(looked_at=was_attached)
    if was_attached:
        bench.report("detached")
    else:
        bench.feed.start()
    bench.begin()
    assert bench.published == ["detached"]
    bench.report("attached")
    bench.send(0)
    bench.wait(10)
    assert bench.published == ["detached", "attached", [0]]

"""The feed of a sensor: valid samples pass, faults are reported."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.inputs.imu import NOTHING, Info, Sample, Status, Vector
from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.loop.clock import VirtualClock
from sar_tui.model.units import MS, SECOND
from sar_tui.motion.samples import SAMPLE

INFO = Info(
    source="test",
    model="By hand",
    rate_hz=250.0,
    rate_range_rad_s=5.0,
    acceleration_range_m_s2=80.0,
)
STILL: Vector = (0.0, 0.0, 0.0)


class ByHand:
    """A source that a test controls."""

    def __init__(self) -> None:
        self.info: Info | None = None
        self.sink: Callable[[Sample], None]
        self.on_status: Callable[[Status], None]
        self.stopped = 0

    def start(self, sink: Callable[[Sample], None], on_status: Callable[[Status], None]) -> None:
        self.sink, self.on_status = sink, on_status

    def stop(self) -> None:
        self.stopped += 1

    def zero(self) -> None: ...


class Bench:
    """A feed, its source and its clock; the sensor's clock is 0 when the host's is."""

    def __init__(self, info: Info = INFO) -> None:
        self.clock = VirtualClock()
        self.source = ByHand()
        self.feed = ImuFeed(self.source, self.clock.now)
        self.feed.start()
        self.attach(info)

    def attach(self, info: Info = INFO) -> None:
        self.source.info = info
        self.source.on_status(Status(state="attached", at=self.clock.now()))

    def send(self, *device_ms: float, rate: Vector = STILL, acceleration: Vector = STILL) -> None:
        for stamp in device_ms:
            finite = stamp if math.isfinite(stamp) else 0.0
            self.source.sink(Sample(round(finite * MS), stamp, acceleration, rate))

    def saturate(self, at_ms: float) -> None:
        self.source.on_status(
            Status(state="saturated", at=round(at_ms * MS), detail="Gyroscope.", count=1)
        )

    def logged(self) -> list[Status]:
        return [status for status in self.feed.drain().statuses if status.state != "attached"]


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_samples_are_unchanged_and_stamped_with_their_measurement_time(bench: Bench) -> None:
    bench.source.sink(Sample(5 * MS, 100.0, (1.0, 2.0, 3.0), (0.1, 0.2, 0.3), (0.4, 0.5, 0.6)))
    bench.source.sink(Sample(8 * MS, 104.0, (1.0, 2.0, 3.0), (0.1, 0.2, 0.3)))
    samples = bench.feed.drain().samples
    assert samples.dtype == SAMPLE
    assert samples["host"].tolist() == [5 * MS, 8 * MS]
    assert samples["at"].tolist() == [5 * MS, 8 * MS]
    assert samples["device_ms"].tolist() == [100.0, 104.0]
    assert np.allclose(samples["acceleration"], [[1, 2, 3]] * 2)
    assert np.allclose(samples["rate"], [[0.1, 0.2, 0.3]] * 2)
    assert np.allclose(samples["field"][0], [0.4, 0.5, 0.6])
    assert np.isnan(samples["field"][1]).all()


@given(st.lists(st.integers(0, 40), max_size=30))
def test_no_drain_loses_or_reorders_samples(blocks: list[int]) -> None:
    bench, sent, come = Bench(), 0, []
    for block in blocks:
        bench.send(*(4.0 * (sent + index) for index in range(block)))
        sent += block
        come += bench.feed.drain().samples["device_ms"].tolist()
    assert come == [4.0 * index for index in range(sent)]
    assert bench.feed.drain().samples.dtype == SAMPLE, "also without any samples"
    assert (bench.feed.received, bench.feed.lost, bench.feed.dropped) == (sent, 0, 0)


@pytest.mark.parametrize("stamp", [4.0, 2.0, -math.inf, math.inf, math.nan, 1e13])
def test_samples_with_non_increasing_stamps_are_left_out_and_reported_once(
    bench: Bench, stamp: float
) -> None:
    bench.send(0.0, 4.0, stamp, stamp, stamp, 8.0)
    samples, statuses = bench.feed.drain()
    assert samples["device_ms"].tolist() == [0.0, 4.0, 8.0]
    assert [status.state for status in statuses] == ["attached", "error"]
    assert "do not increase" in statuses[1].detail
    assert bench.feed.dropped == 3
    bench.send(stamp)
    assert [status.state for status in bench.logged()] == ["error"]


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e300])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_an_invalid_rate_is_left_out_and_its_gap_reported(
    bench: Bench, bad: float, axis: int
) -> None:
    rate: Any = [0.0, 0.0, 0.0]
    rate[axis] = bad
    bench.send(0.0)
    bench.send(4.0, 8.0, rate=tuple(rate))
    bench.send(12.0)
    samples, statuses = bench.feed.drain()
    assert samples["device_ms"].tolist() == [0.0, 12.0]
    assert [(status.state, status.count) for status in statuses] == [
        ("attached", 0),
        ("error", 0),
        ("gap", 2),
    ]
    assert (bench.feed.dropped, bench.feed.lost) == (2, 0)


def test_an_invalid_acceleration_does_not_drop_the_sample(bench: Bench) -> None:
    bench.send(0.0, acceleration=NOTHING)
    bench.send(4.0, acceleration=(1e300, 0.0, 0.0))
    assert len(bench.feed.drain().samples) == 2


def test_a_gap_in_the_sensors_time_is_reported_but_no_jitter_and_none_of_an_unknown_rate(
    bench: Bench,
) -> None:
    bench.send(0.0, 4.0)
    bench.feed.drain()
    bench.send(24.0, 29.9, 32.0, 37.5)
    assert bench.logged() == [Status(state="gap", at=24 * MS, count=4, duration_ms=20.0)]
    assert bench.feed.lost == 4

    unknown = Bench(Info(source="test", model="By hand", rate_hz=0.0))
    unknown.send(0.0, 4.0, 400.0)
    assert unknown.logged() == []


def test_a_gap_is_saturation_if_the_sensor_reported_it(bench: Bench) -> None:
    bench.send(0.0, 4.0)
    for at_ms in (8.0, 12.0, 16.0):
        bench.saturate(at_ms)
    bench.send(20.0, 24.0)
    assert bench.logged() == [
        Status(state="saturated", at=20 * MS, detail="Gyroscope.", count=3, duration_ms=16.0)
    ]
    assert bench.feed.lost == 3
    bench.send(36.0)
    assert [status.state for status in bench.logged()] == ["gap"]


def test_saturation_without_a_gap_is_passed_on(bench: Bench) -> None:
    bench.send(0.0)
    bench.saturate(3.0)
    bench.send(4.0)
    assert bench.logged() == [Status(state="saturated", at=4 * MS, detail="Gyroscope.", count=1)]


def test_saturation_is_reported_although_the_sensor_was_detached(bench: Bench) -> None:
    bench.send(0.0)
    bench.saturate(4.0)
    bench.source.on_status(Status(state="detached", at=5 * MS))
    assert [(status.state, status.count) for status in bench.logged()] == [
        ("saturated", 1),
        ("detached", 0),
    ]


@pytest.mark.parametrize("vector", ["rate", "acceleration"])
def test_samples_at_the_limit_of_the_range_are_kept_and_reported_once_per_drain(
    bench: Bench, vector: str
) -> None:
    limit = {"rate": 5.0, "acceleration": 80.0}[vector]
    bench.send(0.0)
    bench.send(4.0, **{vector: (0.0, -limit, 0.0)})
    bench.send(8.0, **{vector: (0.0, 0.0, limit + 1)})
    bench.send(12.0, **{vector: (0.0, 0.0, limit * 0.99)})
    samples, statuses = bench.feed.drain()
    assert len(samples) == 4
    assert [(status.state, status.count, status.at) for status in statuses[1:]] == [
        ("saturated", 2, 4 * MS)
    ]


@pytest.mark.parametrize("sends", [True, False])
def test_a_silent_sensor_is_stalled_once_and_flows_again(bench: Bench, sends: bool) -> None:
    bench.send(*([0.0] if sends else []))
    bench.feed.drain()
    bench.clock.advance(499 * MS)
    assert bench.logged() == []
    bench.clock.advance(1 * MS)
    assert [(status.state, status.at) for status in bench.logged()] == [("stalled", 500 * MS)]
    bench.clock.advance(2 * SECOND)
    assert bench.logged() == []
    bench.send(2500.0)
    assert [status.state for status in bench.logged()] == ["flowing", *(["gap"] if sends else [])]


def test_a_sensor_that_only_reports_saturation_is_not_stalled(bench: Bench) -> None:
    bench.send(0.0)
    for step in range(1, 20):
        bench.saturate(100.0 * step)
        bench.clock.advance(100 * MS)
        assert bench.logged() == []


@pytest.mark.parametrize("state", ["detached", "ended"])
def test_a_detached_sensor_does_not_stall(bench: Bench, state: Any) -> None:
    bench.send(0.0)
    bench.source.on_status(Status(state=state, at=0))
    bench.feed.drain()
    bench.clock.advance(SECOND)
    assert bench.logged() == []


def test_a_reattached_sensor_restarts_its_clock_without_a_gap(bench: Bench) -> None:
    bench.send(60_000.0, 60_004.0)
    bench.source.on_status(Status(state="detached", at=60_010 * MS))
    bench.attach()
    bench.source.sink(Sample(70_000 * MS, 0.0, STILL, STILL))
    before, after = bench.feed.drain(), bench.feed.drain()
    assert [[status.state for status in drained.statuses] for drained in (before, after)] == [
        ["attached", "detached"],
        ["attached"],
    ]
    assert before.samples["at"].tolist() == [60_000 * MS, 60_004 * MS]
    assert after.samples["at"].tolist() == [70_000 * MS]


def test_an_unannounced_clock_restart_is_a_gap_of_unknown_size(bench: Bench) -> None:
    bench.send(60_000.0)
    bench.source.sink(Sample(60_500 * MS, 0.0, STILL, STILL))
    bench.source.sink(Sample(60_504 * MS, 4.0, STILL, STILL))
    samples, statuses = bench.feed.drain()
    assert samples["at"].tolist() == [60_000 * MS, 60_500 * MS, 60_504 * MS]
    assert [(status.state, status.count) for status in statuses[1:]] == [("gap", 0)]
    assert "began anew" in statuses[1].detail


def test_errors_of_the_sensor_are_passed_on_in_order(bench: Bench) -> None:
    bench.send(0.0, 12.0)
    bench.source.on_status(Status(state="error", at=13 * MS, detail="packet lost"))
    bench.send(24.0)
    assert [status.state for status in bench.logged()] == ["gap", "error", "gap"]


def test_the_rate_is_measured_over_two_seconds(bench: Bench) -> None:
    assert bench.feed.rate_hz == 0.0
    for step in range(500):
        bench.clock.advance(10 * MS)
        stamps = (
            range(step * 10, step * 10 + 10, 4)
            if step < 300
            else range(step * 10, step * 10 + 10, 5)
        )
        bench.send(*map(float, stamps))
        bench.feed.drain()
        if step == 299:
            assert bench.feed.rate_hz == pytest.approx(300)
    assert bench.feed.rate_hz == pytest.approx(200)
    bench.clock.advance(3 * SECOND)
    bench.feed.drain()
    assert bench.feed.rate_hz == 0.0


def test_a_stopped_feed_can_be_drained_and_a_restart_resets_its_counts(bench: Bench) -> None:
    assert bench.feed.info == INFO
    bench.send(0.0, 4.0, 4.0, 40.0)
    bench.feed.stop()
    assert (bench.source.stopped, bench.feed.is_running) == (1, False)
    assert len(bench.feed.drain().samples) == 3
    bench.feed.start()
    counts = bench.feed.received, bench.feed.lost, bench.feed.dropped
    assert (*counts, bench.feed.is_running) == (0, 0, 0, True)

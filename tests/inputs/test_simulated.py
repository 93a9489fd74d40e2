"""The simulated hand as a sensor: samples every 10 ms, the same each time."""

import threading

import numpy as np
import pytest

from sar_tui.inputs.imu import Sample, Status
from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.inputs.simulated import SimulatedSource
from sar_tui.loop.clock import VirtualClock, host_now
from sar_tui.model.units import MS, SECOND
from sar_tui.motion.samples import Samples
from sar_tui.motion.synthesis import PROFILES, ReachShape, SimulatedHand

WAIT_S = 60.0
REACH = ReachShape(out_s=0.6, back_s=0.6, peak_out=4.0, peak_back=-4.0)


def session(profile: str, seconds: int = 3) -> tuple[Samples, list[Status], SimulatedHand]:
    """Return the samples of a reach after one second, drained every 10 ms."""
    clock = VirtualClock(9 * SECOND)
    hand = SimulatedHand(PROFILES[profile], 250.0, seed=3)
    source = SimulatedSource(hand, clock)
    source.move(10 * SECOND, REACH)
    feed = ImuFeed(source, clock.now)
    feed.start()
    come, statuses = [], []
    for _ in range(100 * seconds):
        clock.advance(10 * MS)
        drained = feed.drain()
        come.append(drained.samples)
        statuses += drained.statuses
    feed.stop()
    return np.concatenate(come), statuses, hand


def test_on_a_virtual_clock_samples_are_those_of_the_hand() -> None:
    samples, statuses, hand = session("noisy")
    assert samples.tobytes() == hand.samples(9 * SECOND, 12 * SECOND).tobytes()
    assert [(status.state, status.at) for status in statuses] == [("attached", 9 * SECOND)]


def test_lost_samples_are_gaps() -> None:
    samples, statuses, _ = session("lossy")
    gaps = [status for status in statuses if status.state == "gap"]
    assert sum(gap.count for gap in gaps) == pytest.approx(750 - len(samples), abs=1)
    assert len(gaps) > 30


def test_samples_beyond_the_range_are_missing_and_reported_as_saturation() -> None:
    samples, statuses, _ = session("saturating")
    assert np.abs(samples["rate"]).max() <= 3.0
    assert {status.state for status in statuses} == {"attached", "saturated"}
    assert sum(status.count for status in statuses) == 750 - len(samples)


def test_nothing_arrives_after_a_stop() -> None:
    clock = VirtualClock()
    source = SimulatedSource(SimulatedHand(PROFILES["clean"]), clock)
    received: list[Sample] = []
    source.start(received.append, lambda _: None)
    clock.advance(SECOND)
    source.stop()
    count = len(received)
    clock.advance(SECOND)
    source.zero()
    assert (count, len(received)) == (250, 250)


def test_without_a_clock_it_runs_in_real_time_on_its_own_thread() -> None:
    source = SimulatedSource(SimulatedHand(PROFILES["clean"], 1000.0))
    begun, enough = host_now(), threading.Event()
    received: list[Sample] = []

    def receive(sample: Sample) -> None:
        received.append(sample)
        if len(received) >= 30:
            enough.set()

    source.start(receive, lambda _: None)
    source.move(begun, REACH)
    assert enough.wait(WAIT_S)
    source.stop()
    assert begun <= received[0].host_ns <= received[-1].host_ns <= host_now()
    assert [sample.device_ms for sample in received] == pytest.approx(range(len(received)))
    assert source.info is not None
    assert (source.info.model, source.info.rate_hz) == ("Simulated hand", 1000.0)

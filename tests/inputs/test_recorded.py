"""Recordings as sensors: played in real time or fast, then ended."""

import queue
import threading
from itertools import pairwise
from typing import Any, Literal

import numpy as np
import pytest

from sar_tui.inputs.imu import Sample, SourceError, Status
from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.inputs.recorded import BLOCK, RecordedSource
from sar_tui.loop.clock import VirtualClock, host_now
from sar_tui.model.units import MS, SECOND
from sar_tui.motion.samples import SAMPLE, Samples

WAIT_S = 60.0
"""Time to wait for another thread before a test fails."""


def samples(count: int, step_ms: int = 4) -> Samples:
    made = np.zeros(count, dtype=SAMPLE)
    made["at"] = 77 * SECOND + np.arange(count) * step_ms * MS
    made["device_ms"] = np.arange(count) * step_ms
    made["rate"][:, 2] = np.arange(count)
    made["acceleration"] = made["field"] = np.nan
    return made


def play(source: RecordedSource) -> list[Any]:
    """Return everything that a source sends from its own thread until it ends."""
    come: queue.Queue[Any] = queue.Queue()
    source.start(come.put, come.put)
    received: list[Any] = [come.get(timeout=WAIT_S)]
    while not (isinstance(received[-1], Status) and received[-1].state == "ended"):
        received.append(come.get(timeout=WAIT_S))
    source.stop()
    return received


@pytest.mark.parametrize("speed", ["real time", "fast"])
def test_all_samples_are_played_in_order_and_at_their_times_between_attached_and_ended(
    speed: Literal["real time", "fast"],
) -> None:
    begun = host_now()
    attached, *played, ended = play(RecordedSource(samples(20), speed))
    assert (attached.state, ended.state) == ("attached", "ended")
    assert [sample.rate[2] for sample in played] == [float(number) for number in range(20)]
    assert [sample.device_ms for sample in played] == [4.0 * number for number in range(20)]
    assert all(sample.host_ns - begun >= 4 * MS * number for number, sample in enumerate(played))


def test_played_fast_samples_are_stamped_as_if_played_in_real_time() -> None:
    _, *played, ended = play(RecordedSource(samples(3 * BLOCK + 7), "fast"))
    assert {b.host_ns - a.host_ns for a, b in pairwise(played)} == {4 * MS}
    assert len(played) == 3 * BLOCK + 7
    assert ended.at == played[-1].host_ns


def test_a_source_describes_its_recording() -> None:
    source = RecordedSource(samples(10), "fast", name="walk.csv")
    assert source.info is None
    play(source)
    assert source.info is not None
    assert (source.info.source, source.info.rate_hz) == ("walk.csv", 250.0)
    assert (source.info.has_acceleration, source.info.has_field) == (False, False)


def test_an_hour_is_played_on_a_virtual_clock() -> None:
    clock = VirtualClock(5 * SECOND)
    feed = ImuFeed(RecordedSource(samples(100), clock=clock), clock.now)
    feed.start()
    clock.advance(199 * MS)
    half = feed.drain()
    assert half.samples["at"].tolist() == [5 * SECOND + 4 * MS * number for number in range(50)]
    clock.advance(3600 * SECOND)
    rest, statuses = feed.drain()
    assert (len(rest), [status.state for status in statuses]) == (50, ["ended"])
    assert not clock.step()


def test_a_looped_recording_has_no_gap() -> None:
    clock = VirtualClock()
    feed = ImuFeed(RecordedSource(samples(10), loop=True, clock=clock), clock.now)
    feed.start()
    clock.advance(400 * MS)
    come, statuses = feed.drain()
    assert come["device_ms"].tolist() == [4.0 * number for number in range(101)]
    assert come["rate"][:, 2].tolist() == [float(number % 10) for number in range(101)]
    assert [status.state for status in statuses] == ["attached"]
    feed.stop()
    assert not clock.step()


def test_stop_returns_at_once_although_the_next_sample_is_an_hour_away() -> None:
    source = RecordedSource(samples(3, step_ms=3_600_000))
    first = threading.Event()
    received: list[Sample] = []

    def receive(sample: Sample) -> None:
        received.append(sample)
        first.set()

    source.start(receive, lambda _: None)
    assert first.wait(WAIT_S)
    source.stop()
    assert len(received) == 1


@pytest.mark.parametrize("clock", [None, VirtualClock()])
def test_a_listener_may_stop_the_recording(clock: VirtualClock | None) -> None:
    source = RecordedSource(samples(3 * BLOCK), "fast", clock=clock)
    over = threading.Event()
    states: list[str] = []

    def receive(_: Sample) -> None:
        source.stop()
        over.set()

    source.start(receive, lambda status: states.append(status.state))
    if clock:
        clock.advance(SECOND)
    assert over.wait(WAIT_S)
    source.stop()
    assert states == ["attached"]


def test_a_restarted_recording_is_played_from_the_beginning() -> None:
    source = RecordedSource(samples(5), "fast")
    assert [len(play(source)), len(play(source))] == [7, 7]
    source.stop()
    source.zero()


def test_invalid_recordings_are_refused() -> None:
    with pytest.raises(SourceError, match="two samples"):
        RecordedSource(samples(1))
    with pytest.raises(SourceError, match="without end"):
        RecordedSource(samples(10), "fast", loop=True)

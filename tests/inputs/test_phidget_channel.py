"""Phidget22's own channel: every sample arrives from its callback's thread."""

import math
import queue
import threading

import numpy as np
import pytest

from benchmarks.fake_phidget import FakeSpatial
from sar_tui.drivers.phidget import new_channel
from sar_tui.inputs.imu_feed import Drained, ImuFeed
from sar_tui.inputs.phidget import PhidgetSource
from sar_tui.loop.clock import host_now

WAIT_S = 60.0
"""Time to wait for another thread before a test fails."""


@pytest.mark.parametrize("interval_ms", [4, 1])
def test_five_seconds_of_samples_arrive_whole_in_order_and_in_our_units(interval_ms: int) -> None:
    count = 5000 // interval_ms
    fake = FakeSpatial(new_channel("Spatial"), interval_ms)
    feed = ImuFeed(PhidgetSource(make=lambda: fake.spatial, denied=lambda: False), host_now)
    feed.start()

    sent: queue.Queue[bool] = queue.Queue()

    def send() -> None:
        fake.attach()
        for index in range(count):
            fake.send(index, (90.0, 0.0, -0.01 * index), (1.0, 0.0, -1.0))
            if index % 10 == 9:
                sent.put(True)
        fake.saturate()
        fake.detach()
        sent.put(False)

    driver = threading.Thread(target=send)
    driver.start()
    drained: list[Drained] = []
    while sent.get(timeout=WAIT_S):
        drained.append(feed.drain())
    drained.append(feed.drain())
    driver.join()
    feed.stop()

    samples = np.concatenate([block.samples for block in drained])
    statuses = [status for block in drained for status in block.statuses]
    assert [status.state for status in statuses] == [
        "detached",
        "attached",
        "saturated",
        "detached",
    ]
    assert samples["device_ms"].tolist() == [float(index * interval_ms) for index in range(count)]
    assert (feed.received, feed.lost, feed.dropped) == (count, 0, 0)
    assert (np.diff(samples["at"]) > 0).all()
    assert (np.diff(samples["host"]) >= 0).all()
    assert np.allclose(samples["acceleration"], [9.80665, 0.0, -9.80665])
    assert np.allclose(samples["rate"][:, 0], math.pi / 2)
    assert np.allclose(samples["rate"][:, 2], np.radians(-0.01 * np.arange(count)))
    assert np.allclose(samples["field"], [0.1, 0.2, 0.3])


def test_without_a_device_there_is_a_hint_and_no_error(capfd: pytest.CaptureFixture[str]) -> None:
    feed = ImuFeed(PhidgetSource("1", denied=lambda: False), host_now)
    feed.start()
    feed.source.zero()
    feed.stop()
    assert [(status.state, "1" in status.detail) for status in feed.drain().statuses] == [
        ("detached", True)
    ]
    assert feed.info is None
    assert capfd.readouterr().err == ""


def test_a_missing_server_is_waited_for() -> None:
    feed = ImuFeed(PhidgetSource("//127.0.0.1:1"), host_now)
    for _ in range(2):
        feed.start()
        feed.stop()
        assert [status.state for status in feed.drain().statuses] == ["detached"]

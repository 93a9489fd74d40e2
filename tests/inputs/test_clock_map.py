"""Mapping of a sensor's clock: stamps are accurate and increase, although samples arrive late."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.inputs.imu_feed import ClockMap
from sar_tui.model.units import MS

DELAYS = st.lists(st.integers(0, 50 * MS), min_size=1, max_size=60)


def mapped(device_ms: list[float], host_ns: list[int]) -> list[int]:
    clock = ClockMap()
    return [clock.at(device, host) for device, host in zip(device_ms, host_ns, strict=True)]


@pytest.mark.parametrize("drift_ppm", [-50, 0, 50])
def test_drift_and_delays_are_mapped_to_a_tenth_of_a_millisecond(drift_ppm: int) -> None:
    streams = np.random.default_rng(drift_ppm + 50)
    count = 250 * 600
    device_ms = np.arange(count) * 4.0
    truth = 5_000_000_000_000 + np.rint(device_ms * 1e6 * (1 + drift_ppm * 1e-6)).astype(np.int64)
    delay_ms = streams.exponential(1.0, count) + 20.0 * (streams.random(count) < 0.01)
    host_ns = np.maximum.accumulate(truth + (delay_ms * MS).astype(np.int64))
    at = np.array(mapped(device_ms.tolist(), host_ns.tolist()))
    settled = np.abs(at - truth)[250:] / MS
    assert np.percentile(settled, 99) < 0.1
    assert settled.max() < 0.2
    assert np.diff(at).min() > 0
    assert np.percentile(np.abs(host_ns - truth) / MS, 99) > 10


@given(DELAYS)
def test_stamps_rise_by_at_least_half_of_the_sensors_own_steps_whatever_the_delays(
    delays: list[int],
) -> None:
    device_ms = [4.0 * index for index in range(len(delays))]
    host_ns = [4 * MS * index + delay for index, delay in enumerate(delays)]
    assert all(b - a >= 2 * MS for a, b in pairwise(mapped(device_ms, host_ns)))


@given(DELAYS)
def test_a_sample_is_never_older_than_the_least_delay_allows(delays: list[int]) -> None:
    device_ms = [4.0 * index for index in range(len(delays))]
    host_ns = [4 * MS * index + delay for index, delay in enumerate(delays)]
    assert all(at >= 4 * MS * index for index, at in enumerate(mapped(device_ms, host_ns)))


def test_one_prompt_sample_corrects_later_stamps_gradually() -> None:
    device_ms = [4.0 * index for index in range(6)]
    at = mapped(device_ms, [9 * MS, 11 * MS, 8 * MS, 42 * MS, 46 * MS, 50 * MS])
    assert at == [9 * MS, 11 * MS, 13 * MS, 15 * MS, 17 * MS, 20 * MS + 3 * 400]


def test_stamps_increase_after_a_clock_jumps_back() -> None:
    at = mapped([10_000.0, 10_004.0, 0.0, 4.0], [100 * MS, 104 * MS, 900 * MS, 904 * MS])
    assert at == [100 * MS, 104 * MS, 900 * MS, 904 * MS]


def test_a_restarted_clock_is_mapped_anew() -> None:
    clock = ClockMap()
    clock.at(1000.0, 50 * MS)
    clock.restart()
    assert clock.at(2000.0, 60 * MS) == 60 * MS


def test_stamps_increase_even_if_a_new_clock_seems_earlier() -> None:
    clock = ClockMap()
    clock.at(1000.0, 50 * MS)
    clock.restart()
    assert clock.at(0.0, 40 * MS) == 50 * MS + 1

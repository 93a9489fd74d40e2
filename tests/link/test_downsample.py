"""Downsampling of motion sensor samples."""

import numpy as np
import pytest

from sar_tui.link.broker import INTERVAL, MAX_POINTS, Downsampler
from sar_tui.model.units import MS, SECOND
from sar_tui.motion.samples import SAMPLE, pack


def block(start: int, count: int, rate_hz: float, speed: float) -> bytes:
    """Samples of a hand that turns steadily about y."""
    samples = np.zeros(count, dtype=SAMPLE)
    samples["at"] = start + np.arange(count) * round(SECOND / rate_hz)
    samples["rate"][:, 1] = -speed
    return pack(samples)


@pytest.mark.parametrize("rate_hz", [50, 250, 1000])
def test_one_second_becomes_about_a_dozen_small_traces(rate_hz: int) -> None:
    downsampler, traces = Downsampler(), []
    for start in range(0, SECOND, 40 * MS):
        downsampler.add("B", block(start, rate_hz // 25, rate_hz, 2.5))
        traces += downsampler.due(start + 40 * MS)
    assert 5 < len(traces) <= SECOND // INTERVAL + 1
    assert {trace.seat for trace in traces} == {"B"}
    assert all(0 < len(trace.rates) <= MAX_POINTS for trace in traces)
    assert {rate for trace in traces for rate in trace.rates} == {2.5}
    assert all(trace.hz <= 61 for trace in traces[1:])
    assert traces[-1].at <= SECOND


def test_number_of_points_is_limited() -> None:
    downsampler = Downsampler()
    downsampler.add("A", block(0, 5000, 1000, 1.0))
    (trace,) = downsampler.due(5 * SECOND)
    assert len(trace.rates) == MAX_POINTS


def test_invalid_samples_are_rejected() -> None:
    with pytest.raises(ValueError, match="size"):
        Downsampler().add("A", b"abc")

"""A recording of any length is analysed in bounded memory, and one that fits exactly as a whole."""

import tracemalloc
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest

from sar_tui.motion.detection import (
    DETECTORS,
    SHORTEST_WINDOW_S,
    LongDetection,
    detect,
    detect_long,
)
from sar_tui.motion.samples import SAMPLE, Samples, recording
from sar_tui.motion.synthesis import PROFILES, TABLE_4_1, SimulatedHand
from tests.examples import first

RATE_HZ = 60.0
SMALL = 1000
"""So few that a window has its shortest duration."""
SECOND = 1_000_000_000
BEGIN = 1_700_000_000 * SECOND


def reaches(count: int, profile: str = "steady", every_s: int = 4) -> Iterator[Samples]:
    """Yield samples in blocks of ten seconds: a reach every few seconds, and a minute's rest now
    and then.
    """
    hand, now = SimulatedHand(PROFILES[profile], RATE_HZ, seed=2), BEGIN
    for number in range(count):
        hand.move(now + 2 * SECOND, TABLE_4_1[number % 8].shape)
        until = now + (60 if number % 25 == 24 else every_s) * SECOND
        while now < until:
            then = min(now + 10 * SECOND, until)
            yield hand.samples(now, then)
            now = then


def onsets(found: LongDetection) -> list[float]:
    return [reach.onset_s for reach in found.reaches]


@pytest.mark.parametrize("detector", DETECTORS)
def test_a_recording_that_fits_is_analysed_as_a_whole(detector: str) -> None:
    blocks = list(reaches(12))
    samples = np.concatenate(blocks)
    whole = recording(samples, BEGIN)
    found = detect_long(blocks, detector)
    expected = detect(whole, detector)
    assert len(expected) == 12
    for now, then in zip(found.reaches, expected, strict=True):
        assert now.onset_s == then.onset_s + BEGIN / 1e9
        for name in ("reach_time_s", "sparc_out", "tremor_index"):
            assert getattr(now, name) == getattr(then, name)
    assert (found.rate_hz, found.samples) == (whole.rate_hz, len(samples))


@pytest.mark.slow
@pytest.mark.parametrize("profile", first(1, ["patient", "steady"]))
@pytest.mark.parametrize("detector", DETECTORS)
def test_in_windows_the_same_reaches_are_found(detector: str, profile: str) -> None:
    profile = "clean" if detector == "fixed-threshold" else profile
    whole = detect_long(reaches(150, profile), detector)
    found = detect_long(reaches(150, profile), detector, window=SMALL)
    assert len(whole.reaches) == 150
    assert onsets(found) == pytest.approx(onsets(whole), abs=0.01)
    for now, then in zip(found.reaches, whole.reaches, strict=True):
        assert now.reach_time_s == pytest.approx(then.reach_time_s, abs=0.01)
        assert now.peak_extension_rad_s == pytest.approx(then.peak_extension_rad_s, abs=0.01)
        assert now.flags == then.flags
    assert found[1:] == pytest.approx(whole[1:])


@pytest.mark.slow
def test_the_result_does_not_depend_on_the_blocks_unless_there_are_none() -> None:
    with pytest.raises(ValueError, match="There are no samples"):
        detect_long([])
    whole = np.concatenate(list(reaches(80)))
    parts = np.split(whole, [500, 501, 3000, 9000, 9100])
    assert detect_long([whole], window=SMALL).reaches == detect_long(parts, window=SMALL).reaches


@pytest.mark.slow
def test_memory_does_not_grow_with_the_recording() -> None:
    peaks = []
    for count in (60, 180):
        tracemalloc.start()
        try:
            found = detect_long(reaches(count), "fixed-threshold", window=SMALL)
            assert len(found.reaches) == count
            peaks.append(tracemalloc.get_traced_memory()[1])
        finally:
            tracemalloc.stop()
    assert peaks[1] < 1.1 * peaks[0]


def test_what_lies_beyond_a_long_hole_is_analysed_by_itself() -> None:
    blocks = list(reaches(10))
    later = [block.copy() for block in blocks]
    for block in later:
        block["at"] += 24 * 3600 * SECOND
    found = detect_long([*blocks, *later], window=SMALL)
    first, second = onsets(found)[:10], onsets(found)[10:]
    assert second == pytest.approx([onset + 24 * 3600 for onset in first], abs=1e-5)
    assert found.lasts_s > 24 * 3600


def test_a_movement_without_a_rest_does_not_fill_the_memory() -> None:
    """A sensor whose bias is above the fixed threshold: it never rests."""
    found = detect_long(reaches(150, "biased"), "fixed-threshold", window=SMALL)
    (endless,) = found.reaches
    assert "endless" in endless.flags
    assert endless.reach_time_s == pytest.approx(SHORTEST_WINDOW_S, abs=1.0)


def restless(seed: int, lasts_s: float = 400.0, rate_hz: float = 50.0) -> Samples:
    """Return samples of a hand that turns out and back about one axis after another, often without
    a rest.
    """
    generator = np.random.default_rng(seed)
    time_s = np.arange(round(lasts_s * rate_hz)) / rate_hz
    rate = generator.normal(0.0, 0.01, (len(time_s), 3))
    at_s = 3.0
    while at_s < lasts_s - 5.0:
        axis = generator.normal((0.0, 0.0, 1.5))
        angle = generator.uniform(0.2, 2.0)
        for sign in (1.0, -1.0):
            way_s = generator.uniform(0.3, 1.2)
            share = np.clip((time_s - at_s) / way_s, 0.0, 1.0)
            speed = sign * angle * 30.0 * (share * (1.0 - share)) ** 2 / way_s
            rate += np.outer(speed, axis / np.linalg.norm(axis))
            at_s += way_s + generator.uniform(0.0, 0.3)
        at_s += generator.choice([0.0, 0.3, 3.0]) * generator.random()
    samples = np.zeros(len(time_s), SAMPLE)
    samples["at"] = samples["host"] = BEGIN + np.rint(time_s * SECOND).astype(np.int64)
    samples["rate"] = rate
    samples["acceleration"] = samples["field"] = np.nan
    missing = int(generator.integers(len(samples) - 100))
    return np.delete(samples, range(missing, missing + int(generator.integers(100))))


@pytest.mark.slow
@pytest.mark.parametrize("detector", DETECTORS)
@pytest.mark.parametrize("seed", first(1, range(12)))
def test_reaches_neither_overlap_nor_repeat_and_their_ways_are_in_order(
    detector: str, seed: int
) -> None:
    samples = restless(seed)
    cuts = np.sort(np.random.default_rng([seed, 1]).integers(100, len(samples) - 100, 6))
    found = detect_long(np.split(samples, cuts), detector, window=SMALL).reaches
    assert len(found) > 5
    for one, other in pairwise(found):
        assert one.end_s <= other.onset_s + 1e-6
    for reach in found:
        assert min(reach.out_s, reach.dwell_s, reach.back_s) >= 0.0
        assert reach.onset_s <= reach.turn_s <= reach.end_s
        parts_s = reach.out_s + reach.dwell_s + reach.back_s
        assert parts_s == pytest.approx(reach.reach_time_s, abs=1e-6)

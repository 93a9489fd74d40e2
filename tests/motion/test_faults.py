"""Faults that a sensor does not report: clipping, and another unit."""

import numpy as np
import pytest

from sar_tui.motion.analysis import AnalysisParameters, Window, analyse
from sar_tui.motion.detection import detect
from sar_tui.motion.faults import is_clipped, turns_too_far
from sar_tui.motion.reach_kinds import KINDS
from sar_tui.motion.samples import SAMPLE, Floats, Recording, Samples
from sar_tui.motion.trajectories import simulate_reaches
from tests.examples import fewer, first
from tests.motion.daily_life import KINDS as DAILY_LIFE
from tests.motion.daily_life import simulate as simulate_daily_life


def rate_of(kind: str, seed: int = 1, rate_hz: float = 100.0) -> Floats:
    return simulate_reaches(kind, seed, rate_hz=rate_hz).recording.rate


def samples_of(recording: Recording) -> Samples:
    samples = np.zeros(len(recording.time_s), SAMPLE)
    samples["at"] = np.round(recording.time_s * 1e9)
    samples["rate"] = recording.rate
    samples["acceleration"] = samples["field"] = np.nan
    return samples


@pytest.mark.parametrize("share", [0.5, 0.8])
@pytest.mark.parametrize("kind", first(2, KINDS))
def test_a_plateau_at_any_range_is_clipping(kind: str, share: float) -> None:
    rate = rate_of(kind)
    limit = share * np.abs(rate).max()
    assert is_clipped(np.clip(rate, -limit, limit)) == (limit >= 0.3)


@pytest.mark.parametrize("step_deg_s", [0.0, 0.06, 0.5, 2.0])
@pytest.mark.parametrize("kind", first(3, KINDS))
def test_a_sensor_of_few_steps_is_not_clipped(kind: str, step_deg_s: float) -> None:
    step = np.radians(step_deg_s)
    for seed in range(fewer(20)):
        rate = rate_of(kind, seed, rate_hz=250.0)
        assert not is_clipped(np.round(rate / step) * step if step else rate)


def test_a_clipped_reach_has_its_times_alone() -> None:
    recording = simulate_reaches("cross-arm", 2).recording
    limit = 0.7 * np.abs(recording.rate).max()
    clipped = Recording(recording.time_s, np.clip(recording.rate, -limit, limit))
    (reach,) = detect(clipped)
    assert "clipped" in reach.flags
    samples = samples_of(clipped)
    window = Window(from_ns=0, started_ns=1_000_000_000, to_ns=int(samples["at"][-1]) + 1)
    found = analyse(samples, window, AnalysisParameters())
    assert "clipped" in found.flags
    assert found.details["reach_time_ms"] == pytest.approx(reach.reach_time_s * 1000, abs=1)
    assert found.details["peak_extension_rad_s"] is None


def test_a_reach_in_degrees_turns_too_far_and_neither_one_in_radians_nor_daily_life_does() -> None:
    reaches = [simulate_reaches(kind, 3).recording for kind in KINDS]
    lives = [simulate_daily_life(kind, 1, minutes=1).recording for kind in DAILY_LIFE]
    for recording in (*reaches, *lives):
        assert not turns_too_far(recording.time_s, recording.rate)
    for recording in reaches:
        assert turns_too_far(recording.time_s, np.degrees(recording.rate))


def test_a_window_in_degrees_says_so_whether_or_not_a_reach_is_found() -> None:
    hand = samples_of(simulate_reaches("lift-extend-touch", 2).recording)
    hand["rate"] = np.degrees(hand["rate"])
    window = Window(from_ns=0, started_ns=1_000_000_000, to_ns=int(hand["at"][-1]) + 1)
    assert "too_far" in analyse(hand, window, AnalysisParameters()).flags
    no_reach = Window(
        from_ns=0, started_ns=int(hand["at"][-1]) + 10**10, to_ns=int(hand["at"][-1]) + 1
    )
    assert analyse(hand, no_reach, AnalysisParameters()).onset_ns is None
    assert "too_far" in analyse(hand, no_reach, AnalysisParameters()).flags

"""The analysis of one reach: what is measured, and which of several reaches counts."""

from collections.abc import Callable
from typing import Any

import pytest

from sar_tui.motion import analysis
from sar_tui.motion.analysis import AnalysisParameters, Finding, Window, analyse
from sar_tui.motion.detector_names import COLUMN_NAMES, DetectorName
from sar_tui.motion.reach import Detected, Reach
from sar_tui.motion.samples import Recording
from sar_tui.motion.synthesis import PROFILES, TABLE_4_1, ReachShape, SimulatedHand

SECOND = 1_000_000_000
SMALL, LARGE = TABLE_4_1[0].shape, TABLE_4_1[7].shape


def analysed(
    *moves: tuple[float, ReachShape],
    to_s: float = 5.0,
    started_s: float = 1.5,
    rate_hz: float = 250.0,
    detector: DetectorName = "orientation",
) -> Finding:
    """Return the finding for a hand that makes reaches at times (s)."""
    hand = SimulatedHand(PROFILES["steady"], rate_hz)
    for at_s, shape in moves:
        hand.move(round(at_s * SECOND), shape)
    window = Window(from_ns=0, started_ns=round(started_s * SECOND), to_ns=round(to_s * SECOND))
    samples = hand.samples(0, window.to_ns)
    return analyse(samples, window, AnalysisParameters(detector=detector))


@pytest.fixture
def measured(monkeypatch: pytest.MonkeyPatch) -> list[Detected]:
    """Return a list to which every set of reaches is added that is measured."""
    found: list[Detected] = []

    def measure(detected: Detected, whole: Recording) -> tuple[Reach, ...]:
        found.append(detected)
        return really(detected, whole)

    really = analysis.measure
    monkeypatch.setattr(analysis, "measure", measure)
    return found


@pytest.mark.parametrize("detector", COLUMN_NAMES)
def test_only_the_reach_of_the_detector_that_counts_is_measured(
    measured: list[Detected], detector: DetectorName
) -> None:
    found = analysed((2, SMALL), detector=detector)
    assert len(measured) == 1
    counted = COLUMN_NAMES[detector]
    assert found.details[f"{counted}_reach_time_ms"] == found.details["reach_time_ms"]
    for name in COLUMN_NAMES.values():
        assert found.details[f"{name}_reach_time_ms"] == pytest.approx(1340, abs=120)


def test_a_reach_before_the_window_s_start_is_not_measured(measured: list[Detected]) -> None:
    found = analysed((2, SMALL), (7, SMALL), started_s=6, to_s=10)
    assert [len(detected.reaches) for detected in measured] == [1]
    assert found.onset_ns == pytest.approx(7 * SECOND, abs=SECOND / 25)


@pytest.mark.parametrize("detector", COLUMN_NAMES)
def test_of_several_reaches_the_largest_counts_for_both_detectors(detector: DetectorName) -> None:
    found = analysed((2, SMALL), (6, LARGE), started_s=1, to_s=10, detector=detector)
    assert (found.details["reaches"], found.flags) == (2, ("several",))
    assert found.onset_ns == pytest.approx(6 * SECOND, abs=SECOND / 10)
    for name in COLUMN_NAMES.values():
        assert found.details[f"{name}_reach_time_ms"] == pytest.approx(1080, abs=120)


def test_measures_of_turning_are_rounded() -> None:
    found = analysed((2, SMALL), detector="single-axis")
    assert found.details["excursion_deg"] == pytest.approx(23.3, abs=0.2)
    assert found.details["excursion_deg"] == round(float(found.details["excursion_deg"] or 0), 4)
    assert {"measures_version", "straightness", "tremor_action_rad_s"} <= set(found.details)


def failing(*names: str) -> Callable[..., Detected]:
    """Return `detection.find` in which some detectors fail."""
    really = analysis.find

    def find(whole: Recording, detector: str, *others: Any) -> Detected:
        if detector in names:
            raise ZeroDivisionError
        return really(whole, detector, *others)

    return find


@pytest.mark.parametrize("broken", COLUMN_NAMES)
def test_a_detector_that_does_not_count_can_void_no_reach(
    monkeypatch: pytest.MonkeyPatch, broken: DetectorName
) -> None:
    monkeypatch.setattr(analysis, "find", failing(broken))
    for detector in COLUMN_NAMES:
        found = analysed((2, SMALL), detector=detector)
        assert found.invalid == ("analysis" if detector == broken else "")
        if detector != broken:
            assert found.details[f"{COLUMN_NAMES[broken]}_reach_time_ms"] is None
            assert found.details["reach_time_ms"] == pytest.approx(1340, abs=120)


def test_too_few_samples_a_second_is_a_reason_of_its_own() -> None:
    assert analysed((2, SMALL), rate_hz=15).invalid == "rate"
    assert analysed((2, SMALL), rate_hz=15, detector="fixed-threshold").invalid == ""

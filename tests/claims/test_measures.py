"""Measures of simulated reaches about many axes are near the truth of their trajectories."""

from collections import defaultdict

import numpy as np
import pytest

from sar_tui.motion.detection import detect
from sar_tui.motion.imperfections import PERFECT
from sar_tui.motion.reach import Hand
from sar_tui.motion.reach_kinds import KINDS
from sar_tui.motion.trajectories import PLACEMENTS, simulate_reaches
from tests.claims.measures import true_measures
from tests.examples import fewer, first

LARGEST_OF_95_PERCENT = {
    "excursion_deg": 1.0,
    "return_error_deg": 2.0,
    "inclination_rest_deg": 2.0,
}
LARGEST_MEDIAN = {"inclination_target_deg": 1.0, "straightness": 0.05, "sparc_out": 0.05}


@pytest.mark.parametrize("kind", first(2, sorted(KINDS)))
def test_the_measures_of_each_kind_of_reach_are_near_those_of_its_trajectory(kind: str) -> None:
    errors = errors_of(kind, reaches=fewer(20))
    for name, largest in LARGEST_OF_95_PERCENT.items():
        assert np.percentile(errors[name], 95) <= largest, name
    for name, largest in LARGEST_MEDIAN.items():
        assert np.median(errors[name]) <= largest, name


def errors_of(kind: str, reaches: int) -> dict[str, list[float]]:
    """Return the errors of each measure, of the reaches that are found."""
    errors: dict[str, list[float]] = defaultdict(list)
    for seed in range(reaches):
        arm: Hand = "left" if seed % 2 else "right"
        placement = seed // 2 % len(PLACEMENTS)
        simulated = simulate_reaches(kind, seed, arm=arm, placement=placement)
        ideal = simulate_reaches(kind, seed, arm=arm, placement=placement, imperfections=PERFECT)
        measured = detect(simulated.recording, hand=simulated.site.arm)
        if len(measured) == 1:
            for name, true in true_measures(simulated, ideal).items():
                value = getattr(measured[0], name)
                if value is not None and true is not None:
                    errors[name].append(abs(value - true))
    return errors

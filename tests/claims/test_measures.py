"""Measures of simulated reaches about many axes are near the truth of their trajectories."""

import numpy as np
import pytest

from benchmarks.measures import errors_of
from sar_tui.motion.reach_kinds import KINDS
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

"""The fixed-threshold detector is tested against its definition, and another detector fails that
test.
"""

from typing import Any

import pytest

from sar_tui.motion import fixed_threshold
from sar_tui.motion.fixed_threshold import FixedThresholdParameters
from sar_tui.motion.reach import Detected
from sar_tui.motion.samples import Recording
from sar_tui.validation import threshold_definition
from sar_tui.validation.threshold_definition import claims, crossings


def test_a_movement_crosses_the_threshold_where_its_formula_says() -> None:
    begin_s, lasts_s, peak = 1.0, 2.0, -1.5
    for at_s in crossings((begin_s, lasts_s, peak)):
        share = (at_s - begin_s) / lasts_s
        assert abs(peak) * (4 * share * (1 - share)) ** 2 == pytest.approx(0.1)


def test_the_detector_keeps_to_its_definition() -> None:
    assert [claim.against for claim in claims()] == ["", ""]


@pytest.mark.parametrize(
    ("other", "failed"),
    [
        (FixedThresholdParameters(threshold_rad_s=0.11), [True, True]),
        (FixedThresholdParameters(still_ms=796.0), [False, True]),
        (FixedThresholdParameters(still_ms=804.0), [False, True]),
    ],
)
def test_a_detector_with_another_definition_fails(
    monkeypatch: pytest.MonkeyPatch, other: FixedThresholdParameters, failed: list[bool]
) -> None:
    def find(recording: Recording, _: Any) -> Detected:
        return fixed_threshold.find(recording, other)

    monkeypatch.setattr(threshold_definition, "find", find)
    assert [not claim.holds for claim in claims()] == failed

"""Student's t agrees with scipy."""

import pytest
from scipy.stats import t as student

from sar_tui.rules.student import quantile, t95, within


@pytest.mark.parametrize("df", [1, 2, 3, 4, 7, 30, 37, 126, 999, 2000])
def test_critical_values_are_exact(df: int) -> None:
    assert t95(df) == pytest.approx(student.ppf(0.975, df), rel=1e-10)
    assert quantile(df, 0.8) == pytest.approx(student.ppf(0.9, df), rel=1e-10)
    assert within(1.3, df) == pytest.approx(1 - 2 * student.sf(1.3, df), rel=1e-10)

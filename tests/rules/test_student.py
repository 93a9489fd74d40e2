"""Student's t agrees with scipy's."""

from typing import Any

import pytest

from sar_tui.rules.student import quantile, t95, within


@pytest.mark.parametrize("df", [1, 2, 3, 4, 5, 9, 18, 19, 60, 198, 399])
def test_student_t_is_scipys(df: int, stats: Any) -> None:
    assert t95(df) == pytest.approx(stats.t.ppf(0.975, df), abs=1e-9)
    assert quantile(df, 0.98) == pytest.approx(stats.t.ppf(0.99, df), abs=1e-9)
    assert within(1.3, df) == pytest.approx(1 - 2 * stats.t.sf(1.3, df), abs=1e-9)

"""The judge of the statistics: scipy, imported only by the process that runs these tests, as it takes a second."""

from typing import Any

import pytest


@pytest.fixture(scope="session")
def stats() -> Any:
    """``scipy.stats``."""
    from scipy import stats

    return stats

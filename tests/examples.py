"""Number of examples per property and parametrized test: all, or fewer in a quick run."""

import os
from collections.abc import Iterable
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

QUICK = os.environ.get("SAR_TUI_TEST_EXAMPLES") == "few"
"""`make test` asks for few examples, `make test-all` for all of them."""
_SHARE = 10
_COMMON = settings(
    derandomize=True,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)


def fewer(number: int) -> int:
    """Return a number of examples, or a tenth of it, at least 4, in a quick run."""
    return max(4, number // _SHARE) if QUICK else number


def examples(number: int) -> settings:
    """Return settings for a property with its own number of examples."""
    return settings(_COMMON, max_examples=fewer(number))


def load_profile() -> None:
    """Set the default of every property: 100 examples, or 10 in a quick run."""
    settings.register_profile("sar-tui", examples(100))
    settings.load_profile("sar-tui")


def first(number: int, values: Iterable[Any]) -> list[Any]:
    """Return the values as parameters of a test: in a quick run only the first few, else all, the
    others slow.
    """
    found = list(values)
    return found[:number] + (
        [] if QUICK else [pytest.param(value, marks=pytest.mark.slow) for value in found[number:]]
    )


def first_rows(number: int, rows: Iterable[tuple[Any, ...]]) -> list[Any]:
    """Return the same for a test with several parameters, whose values are rows."""
    found = list(rows)
    return found[:number] + (
        [] if QUICK else [pytest.param(*row, marks=pytest.mark.slow) for row in found[number:]]
    )

"""A plan and a database for tests of the store."""

import sqlite3
from collections.abc import Iterator
from pathlib import Path

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import Plan, make_plan
from sar_tui.store.database import connect


@pytest.fixture
def database(data: Path) -> Iterator[sqlite3.Connection]:
    opened = connect(data)
    yield opened
    opened.close()


@pytest.fixture
def plan(catalogue: Catalogue) -> Plan:
    """A short live session of P01."""
    return make_plan(
        catalogue, "keyboard", ["P01"], {"attempts": 2, "prompts_per_attempt": 3}, seed=11
    )

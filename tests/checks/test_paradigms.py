"""Paradigms written from the docs are simulated, resumed and replayed as the check of tasks does."""

from pathlib import Path

import pytest

from sar_tui.checks.task import check
from tests.documented import write_documented

OWN = Path(__file__).parents[1] / "paradigms"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["oddball", "span"])
def test_a_paradigm_passes_the_check(name: str) -> None:
    assert [each.problems for each in check(OWN / name) if not each.ok] == []


@pytest.mark.parametrize("name", ["stopping", pytest.param("beat", marks=pytest.mark.slow)])
def test_a_task_of_the_page_passes_the_check(tmp_path: Path, name: str) -> None:
    assert [each.problems for each in check(write_documented(tmp_path, name)) if not each.ok] == []

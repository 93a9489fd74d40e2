"""Paradigms written from the docs are simulated, resumed and replayed as the check of tasks
does.
"""

from pathlib import Path

import pytest

from sar_tui.checks.task import check
from tests.documented import write_documented
from tests.edit import edit

OWN = Path(__file__).parents[1] / "paradigms"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["oddball", "span", "cueing"])
def test_a_paradigm_passes_the_check(name: str) -> None:
    assert [each.problems for each in check(OWN / name) if not each.ok] == []


@pytest.mark.parametrize("name", ["stopping", pytest.param("beat", marks=pytest.mark.slow)])
def test_a_task_of_the_page_passes_the_check(tmp_path: Path, name: str) -> None:
    assert [each.problems for each in check(write_documented(tmp_path, name)) if not each.ok] == []


def test_frames_that_never_come_are_reported(tmp_path: Path) -> None:
    task = write_documented(tmp_path, "stopping")
    edit(
        task / "task.py", "frames=frames\n", "frames=(*frames[:1], Frame('X', 2000), Frame('Y'))\n"
    )
    (problem,) = next(done.problems for done in check(task) if not done.ok)
    assert "Frame 3 of 3 would come after the time for the response is over (1000 ms)" in problem

"""Test of the task: `python -m pytest` in its folder."""

from pathlib import Path

from sar_tui.api.testing import check


def test_it_keeps_the_contract_of_tasks_and_simulated_people_can_do_it() -> None:
    assert [
        (done.check, done.problems) for done in check(Path(__file__).parent) if not done.ok
    ] == []

"""A task that keeps something from call to call is found; one that only remembers what it has
computed is not.
"""

from pathlib import Path

import pytest

from sar_tui.checks.task import check
from sar_tui.cli.scaffold import new_task
from sar_tui.plugins import Catalogue
from tests.edit import edit

NAME = "keeps no state from call to call"
VALUE = "value=trial.latency_ms(percept.at),"
BEFORE = "    def instructions"


@pytest.fixture
def task(tmp_path: Path) -> Path:
    """The folder of a new task with one prompt and one key."""
    return new_task("mine", tmp_path, None, Catalogue())


def found(folder: Path) -> tuple[str, ...]:
    """The problems of that check."""
    return next(done.problems for done in check(folder) if done.check == NAME)


def test_a_count_of_calls_in_an_instance_is_found(task: Path) -> None:
    edit(task / "task.py", VALUE, "value=trial.latency_ms(percept.at) + self.more(),")
    edit(task / "task.py", BEFORE, "    seen = 0\n\n    def more(self):\n        self.seen += 1\n"
         "        return self.seen\n\n    def instructions")  # fmt: skip
    (said,) = found(task)
    assert ": In perceived, at attempt " in said
    assert "situation.history" in said


def test_a_list_that_instances_share_is_found(task: Path) -> None:
    edit(task / "task.py", VALUE, "value=trial.latency_ms(percept.at) + len(self.seen),")
    edit(
        task / "task.py",
        "        return Result(",
        "        self.seen.append(percept.at)\n        return Result(",
    )
    edit(task / "task.py", BEFORE, "    seen = []\n\n    def instructions")
    assert found(task)


def test_measures_that_add_up_over_attempts_are_found(task: Path) -> None:
    counting = (
        "    def measures(self, results):\n"
        "        self.total = getattr(self, 'total', 0) + 1\n"
        "        return {'attempts': self.total}\n\n"
    )
    edit(task / "task.py", BEFORE, counting + BEFORE)
    (said,) = found(task)
    assert ": In measures it returned something else" in said


def test_a_note_that_one_method_leaves_for_another_is_found(task: Path) -> None:
    edit(
        task / "task.py",
        "        keys = KEYS",
        "        self.now = situation.trial\n        keys = KEYS",
    )
    edit(task / "task.py", VALUE, "value=trial.latency_ms(percept.at) + self.now,")
    (said,) = found(task)
    assert ": In perceived, at attempt " in said


def test_what_is_computed_once_is_no_state(task: Path) -> None:
    edit(
        task / "task.py",
        "        keys = KEYS[situation.level - 1]",
        "        keys = self.keys(situation.level)",
    )
    edit(task / "task.py", BEFORE, "    def keys(self, level):\n        kept = vars(self).setdefault('kept', {})\n"
         "        return kept.setdefault(level, KEYS[level - 1])\n\n    def instructions")  # fmt: skip
    assert found(task) == ()

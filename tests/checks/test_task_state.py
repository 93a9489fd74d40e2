"""A task that keeps something from call to call is found; one that only remembers what it has
computed is not.
"""

from pathlib import Path

import pytest

from sar_tui.checks.task import check
from sar_tui.cli.scaffold import new_task
from sar_tui.plugins import Catalogue
from tests.edit import edit

VALUE = "value=trial.latency_ms(percept.at),"
KEYS = "        keys = KEYS[situation.level - 1]"
RESULT = "        return Result("
METHODS = "    def instructions"
COUNT = "    seen = 0\n\n    def more(self):\n        self.seen += 1\n        return self.seen\n\n"
MEASURES = """    def measures(self, results):
        self.total = getattr(self, 'total', 0) + 1
        return {'attempts': self.total}

"""
REMEMBERED = """    def keys(self, level):
        kept = vars(self).setdefault('kept', {})
        return kept.setdefault(level, KEYS[level - 1])

"""
PERCEIVED = ": In perceived, at attempt "


@pytest.mark.parametrize(
    ("edits", "said"),
    [
        ({VALUE: f"{VALUE[:-1]} + self.more(),", METHODS: COUNT + METHODS}, PERCEIVED),
        (
            {
                VALUE: f"{VALUE[:-1]} + len(self.seen),",
                RESULT: f"        self.seen.append(percept.at)\n{RESULT}",
                METHODS: f"    seen = []\n\n{METHODS}",
            },
            PERCEIVED,
        ),
        ({METHODS: MEASURES + METHODS}, ": In measures it returned something else"),
        (
            {
                KEYS: f"        self.now = situation.trial\n{KEYS}",
                VALUE: f"{VALUE[:-1]} + self.now,",
            },
            PERCEIVED,
        ),
        ({KEYS: "        keys = self.keys(situation.level)", METHODS: REMEMBERED + METHODS}, ""),
    ],
    ids=["count of calls", "shared list", "measures that add up", "note for another", "no state"],
)
def test_what_is_kept_from_call_to_call_is_found_but_not_what_is_computed_once(
    tmp_path: Path, edits: dict[str, str], said: str
) -> None:
    task = new_task("mine", tmp_path, None, Catalogue())
    for old, new in edits.items():
        edit(task / "task.py", old, new)
    name = "keeps no state from call to call"
    (problems,) = (done.problems for done in check(task) if done.check == name)
    assert len(problems) == bool(said)
    assert said in "".join(problems)

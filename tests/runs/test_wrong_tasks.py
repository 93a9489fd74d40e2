"""A task that breaks the contract ends its session with a sentence; all that is stored can be
read.
"""

from pathlib import Path

import pytest

from tests.examples import first_rows
from tests.program import Call

SOURCE = """
import math
from sar_tui.model.step import Step
from sar_tui.loop.task import Task
from sar_tui.model.trial_types import Metric, Result, Show, Stimulus


class Wrong(Task):
    name = "wrong"
    title = "Wrong"
    metric = Metric("rt", unit="ms", better="lower", improved="faster", worsened="slower")
    trials_per_attempt = 2

    def instructions(self):
        return "Press the key."

    def stimulus(self, situation):
        return Stimulus("a", "a", "Press a")

    def perceived(self, trial, percept):
        value = trial.latency_ms(percept.at)
        return Result(correct=True, response=percept.key, response_at=percept.at, value=value)

    def measures(self, results):
        return {"mean": 1.0}
"""
CASES = [
    ('{"mean": 1.0}', '{"mean": math.nan}', "measures() returned nan for mean, not a finite number: leave it out"),
    ('{"mean": 1.0}', '{"mean": None}', "measures() returned None for mean, not a finite number"),
    ('{"mean": 1.0}', '{"mean": "fast"}', "measures() returned 'fast' for mean, not a finite number"),
    ('{"mean": 1.0}', "{1: 1.0}", "measures() returned {1: 1.0}, not numbers by name"),
    ('{"mean": 1.0}', "[1]", "measures() returned [1], not numbers by name"),
    ("    def measures(self, results)",
     "    def learning(self, attempt, history):\n        return 5\n\n    def other(self)",
     "learning() returned 5, not numbers by name"),
    ('"Press a")', '"Press a", halves="ab")', "The halves of a prompt are a pair of texts, not 'ab'."),
    ('"Press a")', '"Press a", halves=("a", "b", "c"))', "The halves of a prompt are a pair of texts"),
    ('"Press a")', '"Press a", choices="2")', "The choices of a prompt are a whole number, not '2'."),
    ('"Press a")', '"Press a", data=[1])', "The data of a prompt are a dictionary, not [1]."),
    ('Stimulus("a", "a", "Press a")', "None", "stimulus() returned None, not a Stimulus."),
    ("value=value)", 'value=value, show="+10")', "the show of a Result is a Show, such as Show('+10'), not '+10'"),
    ("value=value)", 'value=value, show=Show("+10", ms="5"))', "is shown for a whole number of ms, not '5'"),
    ("return Result(", "return not Result(", "a trial ended with False, which is no Result: look at perceived"),
    ("    def measures(self, results)",
     "    def rehearse(self, stimulus, performance, streams):\n        return None\n\n    def measures(self, results)",
     "The simulated participant failed (TypeError: 'NoneType' object is not iterable"),
    ("trials_per_attempt = 2", "trials_per_attempt = 0", "an attempt at level 1 has 0 trials, not a whole number"),
    ("trials_per_attempt = 2", "trials_per_attempt = 2.5", "an attempt at level 1 has 2.5 trials, not a whole number"),
    ("trials_per_attempt = 2", 'trials_per_attempt = 2\n    steps = (Step(name="a", text="b"))',
     "The steps of a task are a tuple of Step, even if there is one, (Step(…),), not Step(name='a'"),
    ("trials_per_attempt = 2", "trials_per_attempt = 2\n    steps = (5,)", "Among the steps is 5, which is no Step."),
    ("trials_per_attempt = 2", 'trials_per_attempt = 2\n    steps = (Step(name="a", text="b", kind="slider"),)',
     "The step 'a' has the kind 'slider'. Choose one of: screen, rest, calibration, number, likert, borg"),
    ("trials_per_attempt = 2", 'trials_per_attempt = 2\n    steps = (Step(name="a", text="b\\x1b[2J"),)',
     "has control characters: U+001B."),
    ("trials_per_attempt = 2",
     'trials_per_attempt = 2\n    seats = ("A", "B")\n\n    def seat_of(self, key):\n        return None',
     "seat_of() returned None for the key enter, not a seat or an empty text"),
    ("trials_per_attempt = 2", 'trials_per_attempt = 2\n    seats = ("A", "B", "C")',
     "its seats are ('A', 'B', 'C'); they can be"),
]  # fmt: skip


@pytest.mark.parametrize(("right", "wrong", "says"), first_rows(8, CASES))
def test_it_ends_with_a_sentence_and_its_session_can_be_read(
    call: Call, tmp_path: Path, right: str, wrong: str, says: str
) -> None:
    folder = tmp_path / "mytasks" / "wrong"
    folder.mkdir(parents=True)
    assert SOURCE.count(right) == 1
    (folder / "task.py").write_text(SOURCE.replace(right, wrong))
    which = ("--attempts", 1, "--seed", 1, "--tasks", folder.parent)
    people = ("-p", "P02") if 'seats = ("A", "B")\n' in wrong else ()
    called = call("simulate", "wrong", "--user", "average", "-p", "P01", *people, *which)
    assert called.code in (1, 2)
    assert says in called.err.replace("\n", " ")
    assert "Traceback" not in called.err
    for session in call("sessions", "--json").json["sessions"]:
        assert call("replay", session["id"], "--tasks", folder.parent).code == 0

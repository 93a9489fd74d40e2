"""The source of a third-party task with a view of its own, for tests that change it."""

from pathlib import Path

TASK = """
from sar_tui.rules.parameters import TaskParameters
from sar_tui.loop.task import Task
from sar_tui.model.trial_types import Metric, Result, Stimulus


class Sides(Task):
    name = "sides"
    title = "Sides"
    summary = "Press the key of the side that is named."
    metric = Metric("reaction_time", unit="ms", better="lower")

    class Parameters(TaskParameters, frozen=True, kw_only=True):
        prompts_per_attempt: int = 2

    @property
    def trials_per_attempt(self):
        return self.parameters.prompts_per_attempt

    def instructions(self):
        return "Press the key."

    def goal(self, level):
        return "As fast as you can."

    def stimulus(self, situation):
        return Stimulus("f", "f", "Press: f", glyph="f")

    def perceived(self, trial, percept):
        return Result(
            correct=percept.key == "f",
            response=percept.key,
            response_at=percept.at,
            value=trial.latency_ms(percept.at),
        )
"""
VIEW = """
from rich.text import Text

from sar_tui.loop.node import on
from sar_tui.loop.topics import TRIAL
from sar_tui.widgets.task_view import TaskView

from .task import Sides


class SidesView(TaskView):
    def __init__(self, task):
        super().__init__(task)
        assert isinstance(task, Sides)
        self.trials = 0

    @on(TRIAL)
    def trial_ended(self, trial):
        self.trials += 1

    def prompt_lines(self, prompt, width, height):
        return [(f"<<< {prompt.text} >>>" if prompt else f"({self.trials} so far)", True)]

    def between_attempts(self):
        return lambda width, height, colors: Text(f"{self.trials} trials, drawn {width} wide", colors["accent"])

    @classmethod
    def facts(cls, attempts, metric, tr):
        return [f"The view counts {sum(a.trials for a in attempts)}."]
"""


def write_sides(folder: Path, view: str = "") -> Path:
    """Write the task, and its view if there is one, into a folder of tasks. Return the task's
    folder.
    """
    task = folder / "sides"
    task.mkdir(parents=True)
    (task / "task.py").write_text(TASK)
    if view:
        (task / "view.py").write_text(view)
    return task

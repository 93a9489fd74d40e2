"""A task whose prompts follow from what came before: from this attempt's results, and the scores of
others.
"""

from collections.abc import Sequence
from typing import Any

from sar_tui.loop.task import Task
from sar_tui.model.trial_types import Mark, Metric, PastAttempt, Result, Situation, Stimulus, Trial


class Contrast(Task):
    """``f`` is right. Each right answer makes the next prompt harder, each wrong one easier."""

    name = "contrast"
    title = "Contrast"
    metric = Metric("contrast", "", "higher")
    marks = (Mark("slip", "f7", "Slip", counts=False, remark="Take your time."),)

    @property
    def trials_per_attempt(self) -> int:
        """Six prompts."""
        return 6

    def instructions(self) -> str:
        """Return the instructions."""
        return "Press f."

    def stimulus(self, situation: Situation) -> Stimulus:
        """Return a prompt that names its contrast, and the correct answers of the attempts
        before.
        """
        contrast = 10 + sum(1 if result.correct else -1 for result in situation.results)
        before = "-".join(str(past.score.correct) for past in situation.history)
        return Stimulus(name=f"c{contrast}", expected="f", text=f"Contrast:{contrast}:{before}")

    def perceived(self, trial: Trial, percept: Any) -> Result:
        """Judge the key. The value is the contrast."""
        return Result(
            correct=percept.key == "f",
            response=percept.key,
            response_at=percept.at,
            value=float(trial.stimulus.name[1:]),
        )

    def learning(self, attempt: PastAttempt, history: Sequence[PastAttempt]) -> dict[str, float]:
        """Return the gain in right answers over the attempt before."""
        return {"gain": float(attempt.score.correct - history[-1].score.correct)} if history else {}

"""A digit span, written from docs/write-your-own-task.md: digits appear one after the other, then
they are typed.
"""

from typing import Annotated

from sar_tui.loop.task import Task
from sar_tui.model.trial_types import Frame, Metric, Result, Stimulus
from sar_tui.rules.declaration import meta
from sar_tui.rules.parameters import TaskParameters

DIGITS = "123456789"


class SpanParameters(TaskParameters, frozen=True, kw_only=True):
    threshold: Annotated[
        float, meta("Goal", "digits", "The mean has to be above this.", ge=1, le=9)
    ] = 2.5
    neutral_band: Annotated[float, meta("Band", "digits", "About the goal.", ge=0, le=5)] = 0.0
    digit_ms: Annotated[
        int, meta("Time of a digit", "ms", "How long each digit stands.", ge=100, le=5000)
    ] = 300
    max_level: Annotated[int, meta("Highest level", help="Adds a digit each.", ge=1, le=6)] = 3


class Span(Task):
    name = "span"
    title = "Digit span"
    metric = Metric(
        "span", unit="digits", better="higher", improved="longer", worsened="shorter", decimals=1
    )
    Parameters = SpanParameters

    @property
    def trials_per_attempt(self):
        return 2

    def instructions(self):
        return "Remember the digits, and type them in the same order."

    def stimulus(self, situation):
        left, chosen = list(DIGITS), []
        for place in range(2 + situation.level):
            chosen.append(situation.streams.choice(left, "digit", place))
            left.remove(chosen[-1])
        shown = tuple(
            Frame(digit, self.parameters.digit_ms, text=f"Digit: {digit}") for digit in chosen
        )
        asked = Frame("?", text="Type the digits.", timed=True, awaited=True)
        return Stimulus("".join(chosen), "", "Digits", frames=(*shown, asked), signals=False)

    def perceived(self, trial, percept):
        typed = "".join(each.key for each in (*trial.percepts, percept))
        asked = trial.stimulus.name
        if len(typed) < len(asked):
            return None
        is_right = typed == asked
        return Result(
            correct=is_right,
            response=typed,
            response_at=percept.at,
            value=len(asked) if is_right else None,
        )

    def rehearse(self, stimulus, performance, streams):
        typed = stimulus.name[::-1] if performance.slips else stimulus.name
        return [(performance.reaction_ms + 300 * place, digit) for place, digit in enumerate(typed)]

"""Choice reaction: a key appears, and is pressed as fast as possible."""

from typing import Annotated, Any

import msgspec

from sar_tui.api.task import (
    Details,
    Metric,
    Result,
    Situation,
    Stimulus,
    Task,
    TaskParameters,
    Trial,
    meta,
)

# The keys of each level, easiest first.
KEYS = ("fj", "dfj", "dfjk", "sdfjk", "sdfjkl")


class ExampleParameters(TaskParameters, frozen=True, kw_only=True):
    """Parameters of the task. Each is a field on the settings form, and `--set NAME=VALUE` on the
    command line.

    The common ones of `TaskParameters` are inherited; redeclare one to change its default or
    bounds. ``meta`` takes a title, a unit, a sentence of help, and inclusive bounds.
    """

    prompts_per_attempt: Annotated[
        int, meta("Prompts per attempt", help="Number of keys in an attempt.", ge=1, le=100)
    ] = 10
    threshold: Annotated[
        float,
        meta(
            "Goal",
            "ms",
            "The mean reaction time of an attempt must be below this.",
            ge=100,
            le=10_000,
        ),
    ] = 800.0


class ExampleDetails(Details, frozen=True):
    """Details stored with each trial in ``trials.details``, besides the common columns."""

    choices: Annotated[
        int, msgspec.Meta(description="Number of keys that the prompt was drawn from.")
    ]


class ExampleTask(Task):
    """One trial is one prompt and one key. The metric is the mean reaction time of right responses.

    A task keeps no state between calls, so that a trial can be repeated, resumed and replayed.
    """

    name = "example"  # the folder has the same name
    title = "Choice reaction"
    summary = "Press the key that appears, as fast as you can."
    metric = Metric(
        "reaction_time", unit="ms", better="lower", improved="faster", worsened="slower"
    )
    Parameters = ExampleParameters
    Details = ExampleDetails
    parameters: ExampleParameters

    @property
    def levels(self) -> int:
        return len(KEYS)

    @property
    def trials_per_attempt(self) -> int:
        return self.parameters.prompts_per_attempt

    def instructions(self) -> str:
        """Shown before the first attempt."""
        return (
            "A key appears on the screen. Press it as fast as you can.\nTo pause at any time, "
            "press Escape."
        )

    def stimulus(self, situation: Situation) -> Stimulus:
        """Return the prompt. It depends on the situation alone: draw random values from
        ``situation.streams``.
        """
        keys = KEYS[situation.level - 1]
        key = situation.streams.choice(keys, "key")
        return Stimulus(
            name=key,  # stored with the trial, and shown very large
            expected=key,
            text=f"Press: {key}",  # for screen readers: one line
            choices=len(keys),
        )

    def perceived(self, trial: Trial, percept: Any) -> Result:
        """Judge a key press while the prompt is shown."""
        return Result(
            correct=percept.key == trial.stimulus.expected,
            response=percept.key,
            response_at=percept.at,
            # the metric of an attempt is the mean of its right trials' values
            value=trial.latency_ms(percept.at),
            details={"choices": trial.stimulus.choices},
        )

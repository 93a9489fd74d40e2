"""Finger tapping: tap the keys in turn, as often as you can, until the time is over."""

from collections.abc import Sequence
from typing import Annotated, Any

import msgspec

from sar_tui.api.task import (
    Act,
    Details,
    KeyPerceived,
    Metric,
    Performance,
    RandomStreams,
    Result,
    Situation,
    Stimulus,
    Task,
    TaskParameters,
    Trial,
    meta,
)

# The keys of each level, easiest first; they are tapped in turn, again and again.
SEQUENCES = ("f", "fj", "dfj", "dfjk", "sdfjkl")


class DrummingParameters(TaskParameters, frozen=True, kw_only=True):
    """Parameters of the task. Each is a field on the settings form, and `--set NAME=VALUE` on the
    command line.

    The common ones of `TaskParameters` are inherited; redeclare one to change its default or
    bounds. ``meta`` takes a title, a unit, a sentence of help, and inclusive bounds.
    """

    prompts_per_attempt: Annotated[
        int,
        meta("Turns per attempt", help="Number of turns of tapping in an attempt.", ge=1, le=20),
    ] = 3
    threshold: Annotated[
        float,
        meta("Goal", "taps/s", "The mean rate of an attempt must be above this.", ge=0.1, le=20),
    ] = 3.0
    neutral_band: Annotated[
        float,
        meta(
            "Neutral band",
            "taps/s",
            "Feedback is neutral within this distance of the goal, on either side.",
            ge=0,
            le=5,
        ),
    ] = 0.1
    response_timeout_ms: Annotated[
        int, meta("Tapping time", "ms", "Duration of a turn of tapping.", ge=1000, le=60_000)
    ] = 5000
    wrong_share: Annotated[
        float,
        meta(
            "Wrong taps allowed",
            help="The share of wrong taps a turn may have, 0 to 1.",
            ge=0,
            le=1,
        ),
    ] = 0.2


class DrummingDetails(Details, frozen=True):
    """Details stored with each trial in ``trials.details``, besides the common columns."""

    taps: Annotated[int, msgspec.Meta(description="Number of taps, right or wrong.")]
    wrong: Annotated[
        int, msgspec.Meta(description="Number of taps that were not the next key of the sequence.")
    ]


class DrummingTask(Task):
    """One trial is one turn of tapping. The metric is the rate of right taps.

    A task keeps no state between calls, so that a trial can be repeated, resumed and replayed.
    """

    name = "drumming"  # the folder has the same name
    title = "Finger tapping"
    summary = "Tap the keys in turn, as often as you can."
    metric = Metric(
        "tapping_rate",
        unit="taps/s",
        better="higher",
        improved="faster",
        worsened="slower",
        decimals=1,
    )
    Parameters = DrummingParameters
    Details = DrummingDetails
    parameters: DrummingParameters

    @property
    def levels(self) -> int:
        return len(SEQUENCES)

    @property
    def trials_per_attempt(self) -> int:
        return self.parameters.prompts_per_attempt

    def instructions(self) -> str:
        """Shown before the first attempt."""
        seconds = self.parameters.response_timeout_ms / 1000
        return (
            "Some keys appear on the screen.\n"
            "Tap them in turn, from left to right and then again from the left, as often as you "
            "can.\n\n"
            f"After {seconds:g} seconds they disappear, and you may rest.\n"
            "To pause at any time, press Escape."
        )

    def stimulus(self, situation: Situation) -> Stimulus:
        """Return the prompt. It depends on the situation alone: draw random values from
        ``situation.streams``.
        """
        keys = SEQUENCES[situation.level - 1]
        return Stimulus(
            name=keys,
            expected="",  # no single key ends this trial
            text=f"Tap: {keys}",  # for screen readers: one line
            glyph=keys,  # shown very large
            hint="again and again",
            choices=len(keys),
        )

    def perceived(self, trial: Trial, percept: Any) -> Result | None:
        """Judge a key press while the prompt is shown. None: keep waiting; the press is added to
        ``trial.percepts``.
        """
        return None

    def timed_out(self, trial: Trial) -> Result:
        """Judge the trial when it times out."""
        taps: Sequence[KeyPerceived] = [percept for percept in trial.percepts if not percept.repeat]
        if not taps:
            return Result(correct=False, details={"taps": 0, "wrong": 0})
        keys = trial.stimulus.name
        right = 0
        for tap in taps:
            if tap.key == keys[right % len(keys)]:
                right += 1
        wrong = len(taps) - right
        seconds = self.parameters.response_timeout_ms / 1000
        return Result(
            correct=wrong <= self.parameters.wrong_share * len(taps),
            response="".join(tap.key for tap in taps),
            response_at=taps[0].at,
            value=right / seconds,  # the metric of an attempt is the mean of its trials' values
            details={"taps": len(taps), "wrong": wrong},
        )

    def rehearse(
        self, stimulus: Stimulus, performance: Performance, streams: RandomStreams
    ) -> list[Act]:
        """Return the key presses of a simulated participant: (ms after onset, key)."""
        pace = performance.reaction_ms / 2
        duration = self.parameters.response_timeout_ms
        first = performance.reaction_ms
        times = [first + pace * tap for tap in range(int((duration - first) / pace))]
        keys = [stimulus.name[tap % len(stimulus.name)] for tap in range(len(times))]
        if performance.slips:
            keys = [
                "x" if streams.uniform("wrong", tap) < 0.5 else key for tap, key in enumerate(keys)
            ]
        return list(zip(times, keys, strict=True))

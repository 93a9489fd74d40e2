"""The rate of healthy adults in the finger tapping test."""

from collections.abc import Sequence
from statistics import fmean

from sar_tui.api.task import Act, Effect, Performance, RandomStreams, Stimulus, TrialEnded

from .task import KEY, TappingTask


def without_hurry(
    task: TappingTask, stimulus: Stimulus, performance: Performance, streams: RandomStreams
) -> list[Act]:
    """Return the acts of a person who taps once a second."""
    return [(at, KEY) for at in range(500, round(task.parameters.seconds * 1000), 1000)]


def taps(trials: Sequence[TrialEnded]) -> float | None:
    """Return the mean number of taps."""
    counts = [trial.value for trial in trials if trial.value is not None]
    return fmean(counts) if counts else None


EFFECT = Effect(
    title="taps in ten seconds",
    unit="taps",
    low=50,
    high=60,
    source="FePsy, after Halstead-Reitan: 50 to 60",
    measure=taps,
    without=without_hurry,
    settings={"attempts": 5},
)

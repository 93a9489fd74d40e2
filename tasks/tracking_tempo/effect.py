"""The negative mean asynchrony of movements in time with a metronome."""

from collections.abc import Sequence
from statistics import fmean

from sar_tui.api.task import Act, Effect, Performance, RandomStreams, Stimulus, TrialEnded

from .task import TrackingTempoTask, swings


def on_the_beat(
    task: TrackingTempoTask, stimulus: Stimulus, performance: Performance, streams: RandomStreams
) -> list[Act]:
    """Return the acts of a person who is not ahead of the beat."""
    beat = float(stimulus.data["beat_ms"])
    return swings(beat, task.parameters.beats, performance.unsteadiness, streams, ahead_ms=0.0)


def asynchrony_ms(trials: Sequence[TrialEnded]) -> float | None:
    """Return the mean time from a beat to the turn at it, ms."""
    found = [trial.details["asynchrony_ms"] for trial in trials if trial.correct]
    values = [value for value in found if isinstance(value, float)]
    return fmean(values) if values else None


EFFECT = Effect(
    title="turn minus beat",
    unit="ms",
    low=-80,
    high=-20,
    source="Repp & Su 2013: ahead of the beat; the limits are ours",
    measure=asynchrony_ms,
    without=on_the_beat,
    settings={"attempts": 2},
)

"""The learning of the sequence in the serial reaction time task."""

from collections.abc import Sequence

from sar_tui.api.task import (
    Act,
    Effect,
    Performance,
    RandomStreams,
    Stimulus,
    TrialEnded,
    mean_time,
)

from .task import RANDOM, SerialTask


def without_learning(
    task: SerialTask, stimulus: Stimulus, performance: Performance, streams: RandomStreams
) -> list[Act]:
    """Return the acts of a person who does not learn the sequence."""
    return [(performance.reaction_ms, stimulus.expected)]


def learnt_ms(trials: Sequence[TrialEnded]) -> float | None:
    """Return the mean reaction time in the last attempt in random order minus that in the attempt
    before it, ms.
    """
    last = max((trial.attempt for trial in trials if trial.data["order"] == RANDOM), default=0)
    before, in_random = (
        mean_time([trial for trial in trials if trial.attempt == attempt])
        for attempt in (last - 1, last)
    )
    return None if before is None or in_random is None else in_random - before


EFFECT = Effect(
    title="random order minus sequence",
    unit="ms",
    low=30,
    high=130,
    source="Nissen & Bullemer 1987: slower in random order; the limits are ours",
    measure=learnt_ms,
    without=without_learning,
    settings={"attempts": 4, "prompts_per_attempt": 60},
)

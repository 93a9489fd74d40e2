"""The effect of a gaze in Posner's cueing task."""

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

from .task import OTHER, PosnerTask


def without_gaze(
    task: PosnerTask, stimulus: Stimulus, performance: Performance, streams: RandomStreams
) -> list[Act]:
    """Return the acts of a person who does not heed where the agent looks."""
    key = OTHER[stimulus.expected] if performance.slips else stimulus.expected
    return [(performance.reaction_ms, key)]


def cueing_ms(trials: Sequence[TrialEnded]) -> float | None:
    """Return the mean reaction time on the side that the agent did not look to, minus that on the
    other, ms.
    """
    valid, other = (
        mean_time([trial for trial in trials if trial.data["valid"] is kind])
        for kind in (True, False)
    )
    return None if valid is None or other is None else other - valid


EFFECT = Effect(
    title="other side minus side of the gaze",
    unit="ms",
    low=10,
    high=30,
    source="Friesen & Kingstone 1998: sooner on the gaze's side; the limits are ours",
    measure=cueing_ms,
    without=without_gaze,
    settings={"attempts": 5, "prompts_per_attempt": 60},
)

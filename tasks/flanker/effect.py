"""The conflict effect of the flanker task."""

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

from .task import OTHER, FlankerTask


def without_conflict(
    task: FlankerTask, stimulus: Stimulus, performance: Performance, streams: RandomStreams
) -> list[Act]:
    """Return the acts of a person whom the arrows beside the middle one do not slow down."""
    key = OTHER[stimulus.expected] if performance.slips else stimulus.expected
    return [(performance.reaction_ms, key)]


def conflict_ms(trials: Sequence[TrialEnded]) -> float | None:
    """Return the mean reaction time to incongruent rows minus that to congruent ones, ms."""
    same, other = (
        mean_time([trial for trial in trials if trial.data["congruent"] is kind])
        for kind in (True, False)
    )
    return None if same is None or other is None else other - same


EFFECT = Effect(
    title="incongruent minus congruent",
    unit="ms",
    low=59,
    high=109,
    source="Fan et al. 2002: 84 (SD 25)",
    measure=conflict_ms,
    without=without_conflict,
    settings={"attempts": 4, "prompts_per_attempt": 24},
)

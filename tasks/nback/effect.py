"""The effect of load in the n-back task."""

from collections.abc import Sequence

from sar_tui.api.task import Act, Effect, Performance, RandomStreams, Stimulus, TrialEnded

from .task import KEY, NbackTask


def without_load(
    task: NbackTask, stimulus: Stimulus, performance: Performance, streams: RandomStreams
) -> list[Act]:
    """Return the acts of a person who remembers two letters as well as one."""
    return (
        [(performance.reaction_ms, KEY)] if stimulus.data["target"] is not performance.slips else []
    )


def load_effect(trials: Sequence[TrialEnded]) -> float | None:
    """Return the share of letters judged right at n = 1 minus that at n = 2, in percent."""
    one, two = ([trial.correct for trial in trials if trial.data["n"] == n] for n in (1, 2))
    return 100 * (sum(one) / len(one) - sum(two) / len(two)) if one and two else None


EFFECT = Effect(
    title="right at n = 1 minus n = 2",
    unit="%",
    low=2,
    high=15,
    source="Bopp & Verhaeghen 2020: nearly all right at 1, fewer at 2; the limits are ours",
    measure=load_effect,
    without=without_load,
    settings={
        "attempts": 6,
        "letters": 30,
        "difficulty_policy": "sequence",
        "level_sequence": (1, 2, 1, 2, 1, 2),
    },
)

"""The commission errors of the Go/No-Go task."""

from collections.abc import Sequence

from sar_tui.api.task import Act, Effect, Performance, RandomStreams, Stimulus, TrialEnded

from .task import GoNoGoTask


def without_haste(
    task: GoNoGoTask, stimulus: Stimulus, performance: Performance, streams: RandomStreams
) -> list[Act]:
    """Return the acts of a person who never presses at a square."""
    return GoNoGoTask.rehearse(task, stimulus, performance, streams) if stimulus.data["go"] else []


def commissions(trials: Sequence[TrialEnded]) -> float | None:
    """Return the share of squares at which the key was pressed, in percent."""
    pressed = [trial.response is not None for trial in trials if not trial.data["go"]]
    return 100 * sum(pressed) / len(pressed) if pressed else None


EFFECT = Effect(
    title="key pressed at squares",
    unit="%",
    low=5,
    high=30,
    source="the limits are ours",
    measure=commissions,
    without=without_haste,
    settings={"attempts": 6, "prompts_per_attempt": 40},
)

"""The time to stop of the stop-signal task."""

from collections.abc import Sequence

from sar_tui.api.task import Act, Effect, Performance, RandomStreams, Stimulus, TrialEnded

from .task import StopSignalTask, stop_signal_rt


def at_once(
    task: StopSignalTask, stimulus: Stimulus, performance: Performance, streams: RandomStreams
) -> list[Act]:
    """Return the acts of a person who stops in no time, whenever the cross comes before the key."""
    if stimulus.data["stop"] and stimulus.data["delay_ms"] < performance.reaction_ms:
        return []
    return StopSignalTask.rehearse(task, stimulus, performance, streams)


def time_to_stop_ms(trials: Sequence[TrialEnded]) -> float | None:
    """Return the stop-signal reaction time of a whole session, ms."""
    return stop_signal_rt(trials)


EFFECT = Effect(
    title="stop-signal reaction time",
    unit="ms",
    low=180,
    high=260,
    source="Logan & Cowan 1984: about 200; the limits are ours",
    measure=time_to_stop_ms,
    without=at_once,
    settings={"attempts": 4, "prompts_per_attempt": 60},
)

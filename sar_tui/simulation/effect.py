"""The effect that a task is known for, as its folder declares it in ``effect.py``."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from sar_tui.model.messages import TrialEnded
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import Act, Performance, Stimulus

Rehearsal = Callable[[Any, Stimulus, Performance, RandomStreams], list[Act]]
"""The acts of a simulated participant on a prompt: the task, then as `Task.rehearse`."""


class Effect(NamedTuple):
    """A published effect, and how it is found in a session. ``effect.py`` defines one, named
    ``EFFECT``.

    Attributes:
        title: what it is, in a few words: "incongruent minus congruent".
        unit: of the value.
        low, high: the published range of means.
        source: of that range.
        measure: returns the value of a session from its trials; None if it has none.
        without: what `Task.rehearse` returns for people who do not show the effect: the control.
        settings: of the sessions that are simulated.
    """

    title: str
    unit: str
    low: float
    high: float
    source: str
    measure: Callable[[Sequence[TrialEnded]], float | None]
    without: Rehearsal
    settings: Mapping[str, Any] = {}


def mean_time(trials: Sequence[TrialEnded]) -> float | None:
    """Return the mean reaction time of correct trials, ms; None without any."""
    times = [
        trial.reaction_time_ms
        for trial in trials
        if trial.correct and trial.reaction_time_ms is not None
    ]
    return sum(times) / len(times) if times else None

"""A prompt of many frames, to measure how exactly each is drawn at its time."""

from typing import Any

from sar_tui.loop.task import Task
from sar_tui.model.trial_types import Frame, Metric, Result, Situation, Stimulus, Trial

DURATIONS_MS = (50, 20, 110, 33, 250, 25, 75, 130)
"""Durations of the frames; most are no multiple of a monitor's refresh."""


def frame_text(trial: int, place: int) -> str:
    """Return the plain line of a frame, which no other frame nearby has."""
    return f"[{trial % 10}.{place}]"


class Sequence(Task):
    """Shows frames of known durations, and ends at the first key."""

    name = "sequence"
    title = "Sequence"
    metric = Metric("reaction_time", "ms", "lower")

    @property
    def trials_per_attempt(self) -> int:
        return 20

    def instructions(self) -> str:
        return "Look."

    def stimulus(self, situation: Situation) -> Stimulus:
        texts = [frame_text(situation.trial, place) for place in range(len(DURATIONS_MS) + 1)]
        shown = zip("ABCDEFGHI", (*DURATIONS_MS, None), texts, strict=True)
        frames = tuple(Frame(glyph, ms, text) for glyph, ms, text in shown)
        return Stimulus("sequence", "", "sequence", frames=frames)

    def perceived(self, trial: Trial, percept: Any) -> Result:
        return Result(
            correct=True,
            response=percept.key,
            response_at=percept.at,
            value=trial.latency_ms(percept.at),
        )

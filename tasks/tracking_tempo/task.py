"""Moving in time: the hand swings from side to side, and turns back at each beat of a metronome.

Timing with a metronome is reviewed by Repp & Su (2013, Psychon Bull Rev 20:403-452): people are a
little ahead of the beat, by some tens of milliseconds, and vary by a few percent of its interval.
"""

from collections.abc import Sequence
from statistics import fmean
from typing import Any

from sar_tui.api.task import (
    Act,
    Again,
    Axis,
    Frame,
    Measure,
    Metric,
    Node,
    Performance,
    RandomStreams,
    ReachPerceived,
    Result,
    Situation,
    Stimulus,
    Task,
    Tone,
    Trial,
)

from .beats import LISTENED, in_time, swings
from .parameters import TrackingTempoDetails, TrackingTempoParameters

INTERVALS_MS = (1200.0, 1050.0, 900.0, 800.0, 700.0, 600.0)
"""From beat to beat, for each level."""
BEEP, SEEN_MS = Tone(1000, 60), 150.0
SPARE_MS = 500.0
"""From the end of the beats to the end of the trial: the turns are reported then."""
FOLLOWED = 0.75
"""Share of beats that a right row has a turn at."""


class TrackingTempoTask(Task):
    """One trial is one row of beats. The metric is the variation about the beat, in percent of its
    interval.
    """

    name = "tracking_tempo"
    title = "In time with the beat"
    summary = (
        "Swing your hand from side to side, and turn back at each beat, with a sensor on your hand."
    )
    trains = "Rhythm"
    trials = "Rows"
    metric = Metric(
        "variation",
        unit="%",
        better="lower",
        improved="steadier",
        worsened="less steady",
        decimals=1,
    )
    measured = (
        Measure("asynchrony_ms", "asynchrony", unit="ms", decimals=0),
        Measure("followed", "beats with a turn", unit="%", decimals=0),
    )
    sensors = ("imu",)
    Parameters = TrackingTempoParameters
    Details = TrackingTempoDetails
    parameters: TrackingTempoParameters

    @property
    def levels(self) -> int:
        return len(INTERVALS_MS)

    @property
    def axis(self) -> Axis:
        return Axis("tempo", "beats/min")

    def difficulty(self, level: int) -> float:
        return 60_000 / INTERVALS_MS[level - 1]

    @property
    def trials_per_attempt(self) -> int:
        return self.parameters.prompts_per_attempt

    def level_name(self, level: int) -> str:
        return f"{self.difficulty(level):.0f}/min"

    def nodes(self) -> tuple[Node, ...]:
        from .turns import Turns  # loads numpy

        return (Turns(SPARE_MS / 2),)

    def instructions(self) -> str:
        return self.tr(
            "Listen to the first three beats.\nThen swing your hand from side to side: at each "
            "beat, turn back.\n"
            "Small swings are enough. Go on until the beats end."
        )

    def goal(self, level: int) -> str:
        target = self.target(level)
        most = (
            self.tr("Your goal: less than {most} % off.", most=f"{target.threshold:g}")
            if target
            else ""
        )
        return f"{self.tr('Stay as close to the beat as you can.')}\n{most}"

    def stimulus(self, situation: Situation) -> Stimulus:
        beat, count = INTERVALS_MS[situation.level - 1], self.parameters.beats
        frames: list[Frame] = []
        for number in range(1, count + 1):
            glyph, text = (
                ("○", self.tr("Listen")) if number <= LISTENED else ("●", self.tr("Swing"))
            )
            frames.append(Frame(glyph, SEEN_MS, text=f"{text} {number}", tone=BEEP))
            frames.append(Frame("", beat - SEEN_MS))
        data = {"beat_ms": beat}
        return Stimulus(
            f"{beat:g} ms", "", self.tr("Beats"), frames=tuple(frames), data=data,
            timeout_ms=count * beat + SPARE_MS, signals=False,
        )  # fmt: skip

    def perceived(self, trial: Trial, percept: Any) -> Result | Again | None:
        """Judge the row when the last report of its turns has come."""
        if not isinstance(percept, ReachPerceived) or percept.closed != "timeout":
            return None
        if percept.invalid:
            return Again(
                percept.invalid, self.tr("The sensor missed a part of that, so it does not count.")
            )
        beat_ms = float(trial.stimulus.data["beat_ms"])
        beats = trial.tones if len(trial.tones) == self.parameters.beats else trial.frames[::2]
        turns = [
            seen.turn
            for seen in trial.percepts
            if isinstance(seen, ReachPerceived) and seen.turn is not None
        ]
        found = in_time(beats[LISTENED:], turns, beat_ms)
        right = found.followed >= FOLLOWED and found.variation_ms is not None
        return Result(
            correct=right,
            response="swings" if turns else None,
            response_at=turns[-1] if turns else None,
            value=100 * found.variation_ms / beat_ms
            if right and found.variation_ms is not None
            else None,
            details={**found._asdict(), "beat_ms": beat_ms},
            remark="" if right else self.tr("Wait for the beat, and turn back when you hear it."),
        )

    def measures(self, results: Sequence[Result]) -> dict[str, float]:
        """Return the mean time from the beats to the turns (ms), and the share of beats with a turn
        (%).
        """
        told = [
            (result.details.get("asynchrony_ms"), result.details.get("followed"))
            for result in results
        ]
        ahead, followed = (
            [value for value in column if isinstance(value, float)]
            for column in zip(*told, strict=True)
        )
        found = {"asynchrony_ms": fmean(ahead)} if ahead else {}
        return found | ({"followed": 100 * fmean(followed)} if followed else {})

    def rehearse(
        self, stimulus: Stimulus, performance: Performance, streams: RandomStreams
    ) -> list[Act]:
        """Swing with the beats; in a slip, at a tempo of one's own."""
        beat = float(stimulus.data["beat_ms"])
        own = 1.3 if performance.slips else 1.0
        return swings(
            beat * own, int(self.parameters.beats / own), performance.unsteadiness, streams
        )

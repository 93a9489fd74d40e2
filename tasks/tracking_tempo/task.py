"""Moving in time: the hand swings from side to side, and turns back at each beat of a metronome.

Timing with a metronome is reviewed by Repp & Su (2013, Psychon Bull Rev 20:403-452): people are a
little ahead of the beat, by some tens of milliseconds, and vary by a few percent of its interval.
"""

import math
from collections.abc import Sequence
from statistics import fmean, stdev
from typing import Annotated, Any, NamedTuple

from sar_tui.api.task import (
    Act,
    Again,
    Axis,
    Details,
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
    TaskParameters,
    Tone,
    Trial,
    meta,
)

INTERVALS_MS = (1200.0, 1050.0, 900.0, 800.0, 700.0, 600.0)
"""From beat to beat, for each level."""
BEEP, SEEN_MS = Tone(1000, 60), 150.0
SPARE_MS = 500.0
"""From the end of the beats to the end of the trial: the turns are reported then."""
FOLLOWED = 0.75
"""Share of beats that a right row has a turn at."""
LISTENED = 3
"""Beats at the beginning that are heard only. The next is where the hand sets off, and is not
counted either.
"""
NEAR = 0.4
"""A turn belongs to a beat if it is nearer than this share of the interval."""
AHEAD_MS, NOISE_MS, NOISE_SHARE = 45.0, 18.0, 0.035
"""Simulated people turn so long before the beat, and vary by so much at any tempo and by a share of
the interval.
"""
_SWING_RAD = 0.6


class InTime(NamedTuple):
    """A row of beats.

    Attributes:
        asynchrony_ms: mean time from a beat to its turn; negative: ahead of it; None without any.
        variation_ms: standard deviation of these times; None for fewer than three.
        followed: share of beats that have exactly one turn.
    """

    asynchrony_ms: float | None
    variation_ms: float | None
    followed: float


class TrackingTempoParameters(TaskParameters, frozen=True, kw_only=True):
    """Parameters of the task."""

    imu: Annotated[
        str,
        meta(
            "Motion sensor",
            help="phidget, phyphox://host, udp://:port, serial://port, simulated, recorded:FILE, "
            "or session:ID.",
            min_length=1,
            personal=True,
        ),
    ] = "phidget"
    beats: Annotated[
        int,
        meta(
            "Beats", help="Number of beats in a row. The first three are heard only.", ge=8, le=60
        ),
    ] = 14
    prompts_per_attempt: Annotated[
        int, meta("Rows", help="Number of rows of beats in an attempt.", ge=1, le=20)
    ] = 2
    attempts: Annotated[
        int, meta("Attempts", help="Number of attempts in a session.", ge=1, le=200)
    ] = 6
    threshold: Annotated[
        float,
        meta(
            "Goal",
            "%",
            "The variation about the beat must be below this share of its interval.",
            ge=1,
            le=50,
        ),
    ] = 7.0
    neutral_band: Annotated[
        float,
        meta(
            "Neutral band",
            "%",
            "A result this close to the goal, on either side, is called neither good nor bad.",
            ge=0,
            le=20,
        ),
    ] = 0.2
    max_level: Annotated[
        int, meta("Highest level", help="Each level has a faster beat.", ge=1, le=6)
    ] = 6


class TrackingTempoDetails(Details, frozen=True):
    """Details of a row of beats."""

    asynchrony_ms: Annotated[
        float | None, "Mean time from a beat to the turn at it; negative: ahead of it."
    ] = None
    variation_ms: Annotated[float | None, "Standard deviation of these times."] = None
    followed: Annotated[float | None, "Share of beats with one turn near them, 0 to 1."] = None
    beat_ms: Annotated[float | None, "From beat to beat."] = None


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


def in_time(beats: Sequence[int], turns: Sequence[int], beat_ms: float) -> InTime:
    """Return how turns go with beats, both in ns. The first beat sets the hand in motion, and the
    last ends it.
    """
    found: list[float] = []
    counted = beats[1:-1]
    for beat in counted:
        near = [turn for turn in turns if abs(turn - beat) / 1e6 < NEAR * beat_ms]
        if len(near) == 1:
            found.append((near[0] - beat) / 1e6)
    return InTime(
        asynchrony_ms=fmean(found) if found else None,
        variation_ms=stdev(found) if len(found) > 2 else None,
        followed=len(found) / len(counted) if counted else 0.0,
    )


def swings(
    beat_ms: float,
    beats: int,
    unsteadiness: float,
    streams: RandomStreams,
    ahead_ms: float = AHEAD_MS,
) -> list[Act]:
    """Return the swings of a simulated person, each pair as a movement out and back, from the first
    counted beat on.
    """
    from sar_tui.api.task import ReachShape

    spread = math.hypot(NOISE_MS, NOISE_SHARE * beat_ms) * (1 + unsteadiness)
    noise = streams.generator("beats")
    turns = [
        beat * beat_ms - ahead_ms + noise.gauss(0.0, spread) for beat in range(LISTENED, beats)
    ]
    acts: list[Act] = []
    for begin, turn, end in zip(turns[:-2:2], turns[1:-1:2], turns[2::2], strict=False):
        out, back = (turn - begin) / 1000, (end - turn) / 1000
        peaks = 1.875 * _SWING_RAD
        acts.append(
            (
                begin,
                ReachShape(out_s=out, back_s=back, peak_out=peaks / out, peak_back=-peaks / back),
            )
        )
    return acts

"""The reaching task: out to a marker and back, with a motion sensor on the hand (thesis 4.2.2)."""

import math
from typing import TYPE_CHECKING, Any, Literal

from sar_tui.api.task import (
    Act,
    Again,
    Axis,
    Mark,
    Metric,
    Node,
    Performance,
    Quality,
    RandomStreams,
    ReachPerceived,
    Result,
    Situation,
    Stimulus,
    Target,
    Task,
    Trial,
)

from .parameters import ReachDetails, ReachingParameters

if TYPE_CHECKING:
    from sar_tui.api.task import AnalysisParameters

_AGAIN = {
    "samples": "The sensor sent nothing during that reach, so it does not count.",
    "gap": "The sensor missed a part of that reach, so it does not count.",
    "unfinished": "Your hand was still moving. Come all the way back, let it rest, and then press "
    "Space.",
    "rate": "The sensor is too slow to see a reach. Please fetch the experimenter.",
    "analysis": "That reach could not be measured, so it does not count.",
}

LONGEST_DWELL_S = 5.0
"""Longest rest at the marker that is part of the reach; long, as each trial has one reach only."""
LEANED = "trunk_compensation"
"""Flag of a reach in which the trunk's sensor turned farther than the limit; the key F8 is a mark
of its own.
"""
_UNFINISHED = {"cut", "endless", "timed_out"}
"""Flags of a reach without an end, and so without a time."""
_LEANED = "Try to keep your back against the chair."
_NO_REACH = (
    "I saw no whole reach. Rest your hand, then reach out and come back before you press "
    "Space again."
)


class ReachingTask(Task):
    """Return begins an attempt, space starts and ends each reach. The metric is the mean reach
    time.
    """

    name = "reaching"
    title = "Reaching"
    summary = "Reach out to a marker and back, as fast as you can, with a sensor on your hand."
    trains = "Reaching"
    trials = "Reaches"
    metric = Metric("reach_time", unit="ms", better="lower", improved="faster", worsened="slower")
    Parameters = ReachingParameters
    Details = ReachDetails
    sensors = ("imu",)
    qualities = (
        Quality("sparc", "higher", "smoother", "as smoothly as you can", 0.1),
        Quality("tremor_index", "lower", "steadier", "with a steady hand", 0.02),
        Quality(
            "time_to_peak_share",
            "lower",
            "quicker to its peak",
            "with a quick start",
            0.05,
            praised=False,
        ),
        Quality("movement_units", "lower", "more direct", "without stopping on the way", 1.0),
        Quality("trunk_excursion_deg", "lower", "stiller in the back", "with your back still", 3.0),
    )
    marks = (
        Mark("whole", "f6", "Whole reach", counts=True),
        Mark(
            "missed",
            "f7",
            "Marker missed",
            counts=False,
            remark="Try to touch the marker before you come back.",
        ),
        Mark("compensated", "f8", "Compensated", counts=True),
        Mark(
            "assisted",
            "f9",
            "Assisted",
            counts=False,
            remark="You had some help. Try the next by yourself.",
        ),
    )
    parameters: ReachingParameters

    @property
    def levels(self) -> int:
        return len(self.parameters.marker_distances_cm)

    @property
    def axis(self) -> Axis:
        return Axis("distance", "cm")

    def difficulty(self, level: int) -> float:
        return self.marker_cm(level)

    @property
    def trials_per_attempt(self) -> int:
        return self.parameters.reaches_per_attempt

    @property
    def start_key(self) -> str:
        return "space"

    @property
    def switch_key(self) -> str:
        return self.start_key

    @property
    def has_foreperiod(self) -> bool:
        return self.parameters.go_signal

    @property
    def feedback_on(self) -> Literal["results", "performance", "both"]:
        return self.parameters.feedback_on

    def analysis(self) -> "AnalysisParameters":
        """Return the parameters of the analysis of reaches."""
        from sar_tui.api.task import (  # loads numpy
            AnalysisParameters,
            FixedThresholdParameters,
            OrientationParameters,
            SingleAxisParameters,
        )

        least_rad = math.radians(self.parameters.least_turn_deg)
        longest_s = self.parameters.response_timeout_ms / 1000
        return AnalysisParameters(
            detector=self.parameters.detector,
            hand=self.parameters.hand,
            least_confidence=self.parameters.least_confidence,
            orientation=OrientationParameters(
                least_rad=least_rad,
                dwell_s=LONGEST_DWELL_S,
                longest_s=longest_s,
                ends=self.parameters.reach_ends,
            ),
            single_axis=SingleAxisParameters(
                least_rad=least_rad, dwell_s=LONGEST_DWELL_S, longest_s=longest_s
            ),
            fixed_threshold=FixedThresholdParameters(
                threshold_rad_s=self.parameters.thesis_threshold_rad_s,
                still_ms=self.parameters.thesis_still_ms,
            ),
        )

    def nodes(self) -> tuple[Node, ...]:
        from sar_tui.api.task import ReachPerception  # loads numpy

        return (ReachPerception(self.analysis(), self.parameters.still_ms),)

    def marker_cm(self, level: int) -> float:
        """Return the distance of a level's marker from the start."""
        return self.parameters.marker_distances_cm[level - 1]

    def target(self, level: int) -> Target:
        """Return the target of a level's marker: from ``goal_times_ms``, else made from the
        distance.

        It grows with the square root of the distance, which keeps the peak acceleration of a
        minimum-jerk movement constant (Flash & Hogan 1985: peak acceleration = 5.77 distance /
        time²).
        """
        if self.parameters.goal_times_ms:
            goal = self.parameters.goal_times_ms[level - 1]
        else:
            goal = self.parameters.threshold * math.sqrt(self.marker_cm(level) / self.marker_cm(1))
            goal = float(round(goal))
        return self.target_at(level, goal)

    def target_at(self, level: int, goal: float) -> Target:
        return Target(goal, goal * self.parameters.neutral_band / 100)

    def level_name(self, level: int) -> str:
        return f"{self.marker_cm(level):g} cm"

    # --- words

    def instructions(self) -> str:
        tr = self.tr
        reach = tr("Reach out, touch the marker, and come back, as fast as you can.")
        if self.parameters.go_signal:
            reach = tr(
                "Wait for the signal. Then reach out, touch the marker, and come back, as fast as "
                "you can."
            )
        return (
            f"{tr('Rest your hand with the sensor at the start.')}\n"
            f"{tr('When you are ready, press Space with your other hand.')}\n"
            f"{reach}\n"
            f"{tr('When you are back, press Space again.')}\n\n"
            f"{tr('You may rest before each reach. To pause at any time, press Escape.')}"
        )

    def goal(self, level: int) -> str:
        seconds = f"{self.target(level).threshold / 1000:.2f}"
        there = self.tr("To {marker} and back.", marker=self._marker(level))
        return f"{there}\n{self.tr('Your goal: less than {count} seconds.', count=seconds)}"

    def notice(self, level: int, before: int) -> str:
        if not before:
            return ""
        if level > before:
            return self.tr("Now marker {number}: a little farther", number=level)
        return self.tr("Now marker {number}: a little nearer", number=level)

    def start(self, level: int) -> str:
        tr, marker = self.tr, self._marker(level)
        reach = tr("Then reach to {marker} and back.", marker=marker)
        if self.parameters.go_signal:
            reach = tr("When you see GO, reach to {marker} and back.", marker=marker)
        return f"{tr('Rest your hand at the start.')}\n{reach}"

    def when_to_respond(self) -> str:
        return self.tr("Reach out, come back, and then press Space.")

    def _marker(self, level: int) -> str:
        far = f"{self.marker_cm(level):g} cm"
        if self.levels > 1:
            return self.tr("marker {number} ({far})", number=level, far=far)
        return self.tr("the marker ({far})", far=far)

    # --- trials

    def stimulus(self, situation: Situation) -> Stimulus:
        marker = f"{self.marker_cm(situation.level):g} cm"
        return Stimulus(
            name=marker,
            expected=self.start_key,
            text=self.tr("Reach: {far}", far=marker),
            glyph=self.tr("GO") if self.parameters.go_signal else self.tr("REACH"),
            hint=self.tr("out and back, then press Space"),
            signals=self.parameters.go_signal,
        )

    def perceived(self, trial: Trial, percept: Any) -> Result | Again | None:
        if not isinstance(percept, ReachPerceived):
            return None
        unfinished = _UNFINISHED.intersection(percept.flags) or (
            percept.onset is None and "moving" in percept.flags
        )
        if why := percept.invalid or ("unfinished" if unfinished else ""):
            return Again(why, self.tr(_AGAIN[why]))
        details = {
            **percept.details,
            "marker_cm": self.marker_cm(trial.situation.level),
            "closed": percept.closed,
            "turn_ns": percept.turn,
        }
        if percept.onset is None:
            return Result(
                correct=False,
                details=details,
                flags=(*percept.flags, "no_reach"),
                remark=self.tr(_NO_REACH),
            )
        value = percept.details["reach_time_ms"]
        leaned = self._leaned(percept)
        return Result(
            correct=True,
            response="reach",
            onset_at=percept.onset,
            response_at=percept.end,
            value=float(value) if isinstance(value, int | float) else None,
            details=details,
            flags=(*percept.flags, LEANED) if leaned else percept.flags,
            correction=self.tr(_LEANED) if leaned else "",
        )

    def _leaned(self, reach: ReachPerceived) -> bool:
        """Return True if the trunk turned farther than the therapist allows, as far as its sensor
        tells.
        """
        turned = reach.details.get("trunk_excursion_deg")
        limit = self.parameters.trunk_limit_deg
        return bool(limit) and isinstance(turned, int | float) and turned > limit

    def rehearse(
        self, stimulus: Stimulus, performance: Performance, streams: RandomStreams
    ) -> list[Act]:
        """Reach out and back, then press space. A slip is to forget the key.

        A healthy adult's reach out and back takes 0.85 s to 15 cm, and grows with the distance to
        the power of 0.8: faster than the goal, which grows with the square root.
        """
        from sar_tui.api.task import ReachShape

        distance = float(stimulus.name.split()[0])
        pace = 0.85 * (distance / 15.0) ** 0.8 * performance.pace
        begins = performance.reaction_ms / 1000
        out, back = 0.52 * pace, 0.48 * pace
        amplitude = 0.025 * distance
        halting = streams.uniform("halting") < performance.unsteadiness
        shape = ReachShape(
            out_s=out,
            back_s=back,
            dwell_s=0.3 * performance.unsteadiness * streams.uniform("dwell"),
            peak_out=1.875 * amplitude / out,
            peak_back=-1.875 * amplitude / back,
            submovements=3 if halting and pace > 1.5 else 0,
            seed=int(streams.uniform("shape") * 2**31),
        )
        press = begins + out + back + shape.dwell_s + 0.4 + 0.3 * streams.uniform("press")
        acts: list[Act] = [(begins * 1000, shape)]
        if not performance.slips:
            acts.append((press * 1000, stimulus.expected))
        return acts

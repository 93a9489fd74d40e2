"""Parameters of the pairs task."""

from typing import Annotated, Literal

from sar_tui.api.task import TaskParameters, meta

_WITHOUT_CUE = {
    "gaze": {"speech", "tones", "servo"},
    "gesture": {"speech", "tones"},
    "both": {"speech", "tones"},
}
"""Outputs that cannot give a cue, by its kind."""

Policy = Literal["alternate", "race", "cooperative", "joint attention"]


class PairsParameters(TaskParameters, frozen=True, kw_only=True):
    """Parameters of the pairs task."""

    policy: Annotated[
        Policy,
        meta(
            "Together",
            help="alternate: in turn. race: the faster wins. cooperative: both within a window. "
            "joint "
            "attention: the agent looks to a side first.",
        ),
    ] = "alternate"
    respond_with: Annotated[
        Literal["keys", "reaches"],
        meta(
            "Respond with",
            help="keys: a half of the keyboard each. reaches: out and back, a sensor on a hand "
            "each.",
            personal=True,
        ),
    ] = "keys"
    prompts_per_attempt: Annotated[
        int,
        meta(
            "Prompts per attempt",
            help="Number of prompts in an attempt, for both together.",
            ge=2,
            le=200,
        ),
    ] = 12
    threshold: Annotated[
        float,
        meta(
            "Goal",
            "ms",
            "The mean reaction time of an attempt must be below this; equal is not enough. With "
            "reaches each level takes a tenth off it.",
            ge=100,
            le=60_000,
        ),
    ] = 1000.0
    neutral_band: Annotated[
        float,
        meta(
            "Neutral band",
            "ms",
            "Feedback is neutral within this distance of the goal, on either side.",
            ge=0,
            le=5000,
        ),
    ] = 10.0
    layout: Annotated[
        Literal["qwerty", "azerty", "qwertz"],
        meta(
            "Keyboard layout",
            help="The six letters at the top left of the keyboard.",
            personal=True,
        ),
    ] = "qwerty"
    window_ms: Annotated[
        int,
        meta(
            "Window",
            "ms",
            "Longest time between both responses.",
            ge=20,
            le=10_000,
            group="Cooperative",
        ),
    ] = 400
    congruent_share: Annotated[
        float,
        meta(
            "Congruent share",
            help="Share of prompts on the side that the agent looks to, 0 to 1.",
            ge=0,
            le=1,
            group="Joint attention",
        ),
    ] = 0.5
    cue_lead_ms: Annotated[
        int,
        meta(
            "Cue lead",
            "ms",
            "Time from the agent's cue to the prompt.",
            ge=50,
            le=5000,
            group="Joint attention",
        ),
    ] = 400
    cue_by: Annotated[
        Literal["gaze", "gesture", "both"],
        meta(
            "Cue",
            help="The agent looks (gaze), points (gesture), or both.",
            group="Joint attention",
        ),
    ] = "gaze"
    address: Annotated[
        Literal["seat", "code"],
        meta("Names", help="The agent calls participants by seat (left, right) or by code."),
    ] = "seat"
    imu: Annotated[
        str,
        meta(
            "Sensor on the left",
            help="phidget:SERIAL, phidget://host:port, simulated, recorded:FILE, or session:ID.",
            min_length=1,
            group="Reaches",
            personal=True,
        ),
    ] = "phidget"
    imu_b: Annotated[
        str,
        meta(
            "Sensor on the right",
            help="As on the left, but another sensor.",
            min_length=1,
            group="Reaches",
            personal=True,
        ),
    ] = "phidget"
    hand: Annotated[
        Literal["right", "left"],
        meta(
            "Hand, left participant",
            help="The hand that reaches, with the sensor on it.",
            group="Reaches",
            personal=True,
        ),
    ] = "right"
    hand_b: Annotated[
        Literal["right", "left"],
        meta(
            "Hand, right participant",
            help="The hand that reaches, with the sensor on it.",
            group="Reaches",
            personal=True,
        ),
    ] = "right"

    def problems(self) -> dict[str, str]:
        problems = super().problems()
        if self.policy == "joint attention" and self.cue_lead_ms > self.foreperiod_min_ms:
            problems["cue_lead_ms"] = (
                f"Cue lead ({self.cue_lead_ms} ms) is longer than the shortest wait "
                f"({self.foreperiod_min_ms} ms)."
            )
        kinds = {output.partition(":")[0] for output in self.outputs}
        if self.policy == "joint attention" and kinds <= _WITHOUT_CUE[self.cue_by]:
            does = "points" if self.cue_by == "gesture" else "looks"
            problems["outputs"] = (
                f"Joint attention needs an output that shows where the agent {does}: add screen "
                "to the outputs."
            )
        return problems

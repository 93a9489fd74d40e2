"""Parameters of the pairs task, and the details stored with a trial."""

from typing import Annotated, Literal

import msgspec

from sar_tui.api.task import Details, Sentence, TaskParameters, meta

_WITHOUT_CUE = {
    "gaze": {"speech", "tones", "servo"},
    "gesture": {"speech", "tones"},
    "both": {"speech", "tones"},
}
"""Outputs that cannot give a cue, by its kind."""
Policy = Literal["alternate", "race", "cooperative", "joint attention"]


class PairsDetails(Details, frozen=True):
    """Details of one seat's row; fields that a policy does not use are missing."""

    policy: Annotated[
        str, msgspec.Meta(description="alternate, race, cooperative or joint attention.")
    ]
    choices: Annotated[
        int, msgspec.Meta(description="Number of keys that each seat's was drawn from; 1: a reach.")
    ]
    asked: Annotated[
        str, msgspec.Meta(description="The key that this seat had to press, or reach.")
    ]
    right: Annotated[
        bool, msgspec.Meta(description="True if this seat did it, whatever the other did.")
    ]
    key_gap_ms: Annotated[
        float | None, msgspec.Meta(description="Keys: time since this seat's previous key, in ms.")
    ] = None
    won: Annotated[
        bool | None,
        msgspec.Meta(description="Race: true if this seat had the fastest right response."),
    ] = None
    together: Annotated[
        bool | None,
        msgspec.Meta(description="Cooperative: true if both were right, within the window."),
    ] = None
    between_ms: Annotated[
        float | None,
        msgspec.Meta(description="Cooperative: from one response to the other, in ms."),
    ] = None
    cue: Annotated[
        str | None, msgspec.Meta(description="Joint attention: side of the cue, left or right.")
    ] = None
    congruent: Annotated[
        bool | None,
        msgspec.Meta(description="Joint attention: true if the prompt appeared on that side."),
    ] = None
    cue_lead_ms: Annotated[
        float | None,
        msgspec.Meta(
            description="Joint attention: from handing the cue to the outputs to the prompt's "
            "onset."
        ),
    ] = None
    movement_end_ns: Annotated[
        int | None, msgspec.Meta(description="Reaches: the end of the movement, ns.")
    ] = None
    turn_ns: Annotated[
        int | None, msgspec.Meta(description="Reaches: time stamp of the turn, ns.")
    ] = None
    reach_time_ms: Annotated[
        float | None,
        msgspec.Meta(description="Reaches: from the onset of the movement to its end."),
    ] = None
    out_ms: Annotated[float | None, msgspec.Meta(description="Reaches: the way out.")] = None
    back_ms: Annotated[float | None, msgspec.Meta(description="Reaches: the way back.")] = None
    dwell_ms: Annotated[
        float | None, msgspec.Meta(description="Reaches: the rest between the ways out and back.")
    ] = None
    peak_extension_rad_s: Annotated[
        float | None, msgspec.Meta(description="Reaches: fastest turning on the way out.")
    ] = None
    peak_return_rad_s: Annotated[
        float | None, msgspec.Meta(description="Reaches: on the way back; negative.")
    ] = None
    hand: Annotated[str | None, msgspec.Meta(description="Reaches: the hand that reached.")] = None
    detector: Annotated[
        str | None, msgspec.Meta(description="Reaches: the detector that found the movement.")
    ] = None
    detector_version: Annotated[
        str | None, msgspec.Meta(description="Reaches: version of the detector.")
    ] = None
    samples: Annotated[
        int | None, msgspec.Meta(description="Reaches: number of samples analysed.")
    ] = None
    rate_hz: Annotated[
        float | None,
        msgspec.Meta(description="Reaches: rate of the samples, from the median step."),
    ] = None


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
            "A result this close to the goal, on either side, is called neither good nor bad.",
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
            help="Share of prompts on the side that the agent looks to.",
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
            help="phidget:SERIAL, phyphox://host, udp://:port, serial://port, simulated, recorded:FILE, "
            "or session:ID.",
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
            problems["cue_lead_ms"] = Sentence(
                "Cue lead ({lead} ms) is longer than the shortest wait ({wait} ms).",
                lead=self.cue_lead_ms,
                wait=self.foreperiod_min_ms,
            )
        kinds = {output.partition(":")[0] for output in self.outputs}
        if self.policy == "joint attention" and kinds <= _WITHOUT_CUE[self.cue_by]:
            problems["outputs"] = Sentence(
                "Joint attention needs an output that shows where the agent points: add screen to "
                "the outputs."
                if self.cue_by == "gesture"
                else "Joint attention needs an output that shows where the agent looks: add screen "
                "to the outputs."
            )
        return problems

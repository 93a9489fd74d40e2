"""What is kept of a trial of two beyond the common columns."""

from typing import Annotated

import msgspec

from sar_tui.framework.trial_types import Details


class PairsDetails(Details, frozen=True):
    """One row for each of the two who took part; what a policy does not have is missing."""

    policy: Annotated[str, msgspec.Meta(description="alternate, race, cooperative or joint attention.")]
    choices: Annotated[int, msgspec.Meta(description="Among how many keys each could be asked for; 1: a reach.")]
    asked: Annotated[str, msgspec.Meta(description="The key that this seat was asked for, or reach.")]
    right: Annotated[bool, msgspec.Meta(description="Whether this seat did it, whatever the other did.")]
    key_gap_ms: Annotated[
        float | None, msgspec.Meta(description="Keys: since this seat's key before the response, in ms.")
    ] = None
    won: Annotated[
        bool | None, msgspec.Meta(description="Race: whether this seat's was the fastest right response.")
    ] = None
    together: Annotated[
        bool | None, msgspec.Meta(description="Cooperative: whether both were right, within the window.")
    ] = None
    between_ms: Annotated[
        float | None, msgspec.Meta(description="Cooperative: from one response to the other, in ms.")
    ] = None
    cue: Annotated[str | None, msgspec.Meta(description="Joint attention: where the agent looked, left or right.")] = (
        None
    )
    congruent: Annotated[
        bool | None, msgspec.Meta(description="Joint attention: whether the prompt came up on that side.")
    ] = None
    cue_lead_ms: Annotated[
        float | None,
        msgspec.Meta(description="Joint attention: from handing the cue to the outputs to the prompt's onset."),
    ] = None
    movement_end_ns: Annotated[int | None, msgspec.Meta(description="Reaches: the end of the movement, ns.")] = None
    turn_ns: Annotated[int | None, msgspec.Meta(description="Reaches: where the hand turned, ns.")] = None
    reach_time_ms: Annotated[
        float | None, msgspec.Meta(description="Reaches: from the onset of the movement to its end.")
    ] = None
    out_ms: Annotated[float | None, msgspec.Meta(description="Reaches: the way out.")] = None
    back_ms: Annotated[float | None, msgspec.Meta(description="Reaches: the way back.")] = None
    dwell_ms: Annotated[float | None, msgspec.Meta(description="Reaches: the rest between them.")] = None
    peak_extension_rad_s: Annotated[
        float | None, msgspec.Meta(description="Reaches: fastest turning on the way out.")
    ] = None
    peak_return_rad_s: Annotated[float | None, msgspec.Meta(description="Reaches: on the way back; negative.")] = None
    hand: Annotated[str | None, msgspec.Meta(description="Reaches: the hand that reached.")] = None
    detector: Annotated[str | None, msgspec.Meta(description="Reaches: what found the movement.")] = None
    detector_version: Annotated[str | None, msgspec.Meta(description="Reaches: its version.")] = None
    samples: Annotated[int | None, msgspec.Meta(description="Reaches: how many samples were looked at.")] = None
    rate_hz: Annotated[float | None, msgspec.Meta(description="Reaches: their rate, from the median step.")] = None

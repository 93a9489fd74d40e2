"""Details stored with a trial of the pairs task."""

from typing import Annotated

import msgspec

from sar_tui.api.task import Details


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

"""What is kept of a trial of two beyond the common columns."""

from typing import Annotated

import msgspec

from sar_tui.framework.task import Details


class PairsDetails(Details, frozen=True):
    """One row for each of the two who took part; what a policy does not have is missing."""

    policy: Annotated[str, msgspec.Meta(description="alternate, race, cooperative or joint attention.")]
    choices: Annotated[int, msgspec.Meta(description="Among how many keys each could be asked for.")]
    asked: Annotated[str, msgspec.Meta(description="The key that this seat was asked for.")]
    right: Annotated[bool, msgspec.Meta(description="Whether this seat pressed it, whatever the other did.")]
    key_gap_ms: Annotated[float | None, msgspec.Meta(description="Since this seat's key before the response, in ms.")]
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
        float | None, msgspec.Meta(description="Joint attention: from the cue to the prompt's onset, as measured.")
    ] = None

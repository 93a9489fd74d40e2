"""Responses of the hand: each reaches out and comes back, with a motion sensor on it. The response is its beginning."""

from sar_tui.framework.messages import Json, ReachPerceived
from sar_tui.framework.node import Node
from sar_tui.framework.random_streams import RandomStreams
from sar_tui.framework.trial_types import Act, Performance

from .parameters import PairsParameters

REACH = "reach"
"""What is asked of a hand, and kept as what it did."""
SOONER = (1.0, 0.9, 0.8, 0.7, 0.6, 0.5)
"""What share of the goal is left at each level: with one movement there is nothing to choose from."""
_REST_MS = 850
"""A hand that has rested for so long is back: the fixed-threshold detector needs 800 ms."""
_KEPT = ("reach_time_ms", "out_ms", "back_ms", "dwell_ms", "peak_extension_rad_s", "peak_return_rad_s", "hand",
         "detector", "detector_version", "samples", "rate_hz")  # fmt: skip


def watchers(parameters: PairsParameters) -> tuple[Node, ...]:
    """A node for each hand, which finds its reaches."""
    from sar_tui.motion.analysis import AnalysisParameters  # loads numpy
    from sar_tui.perception.reach import ReachPerception

    return (
        ReachPerception(AnalysisParameters(hand=parameters.hand), _REST_MS, "A"),
        ReachPerception(AnalysisParameters(hand=parameters.hand_b), _REST_MS, "B"),
    )


def details(reach: ReachPerceived | None) -> Json:
    """What is kept of a reach beside its beginning; nothing where none was seen."""
    if reach is None or reach.onset is None:
        return {}
    kept: Json = {name: reach.details.get(name) for name in _KEPT}
    return kept | {"turn_ns": reach.turn, "movement_end_ns": reach.end}


def rehearsed(at_ms: float, performance: Performance, streams: RandomStreams) -> list[Act]:
    """A reach to 20 cm and back, as a healthy adult takes 1.1 s for, begun at ``at_ms``. A slip is but a twitch."""
    from sar_tui.motion.shapes import ReachShape

    if performance.slips:
        return [(at_ms, ReachShape(out_s=0.15, back_s=0.15, peak_out=3.0, peak_back=-3.0))]
    out, back = 0.56 * performance.pace, 0.51 * performance.pace
    shape = ReachShape(
        out_s=out,
        back_s=back,
        dwell_s=0.3 * performance.unsteadiness * streams.uniform("dwell"),
        peak_out=0.94 / out,
        peak_back=-0.94 / back,
        seed=int(streams.uniform("shape") * 2**31),
    )
    return [(at_ms, shape)]

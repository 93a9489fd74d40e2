"""Responses by reaches out and back, with a motion sensor on the hand. Movement onset is the
response.
"""

from sar_tui.api.task import Act, Json, Node, Performance, RandomStreams, ReachPerceived

from .parameters import PairsParameters

REACH = "reach"
"""Name of the response, asked for and stored."""
GOAL_SHARES = (1.0, 0.9, 0.8, 0.7, 0.6, 0.5)
"""The goal of each level, as a share of the first: levels of a single movement differ in nothing
else.
"""
_REST_MS = 850
"""Rest that ends a reach: the fixed-threshold detector needs 800 ms."""
_STORED = (
    "reach_time_ms",
    "out_ms",
    "back_ms",
    "dwell_ms",
    "peak_extension_rad_s",
    "peak_return_rad_s",
    "hand",
    "detector",
    "detector_version",
    "samples",
    "rate_hz",
)


def perception_nodes(parameters: PairsParameters) -> tuple[Node, ...]:
    """Return a node for each hand that finds its reaches."""
    # loads numpy, which other tasks do not need
    from sar_tui.api.task import AnalysisParameters, ReachPerception

    return (
        ReachPerception(AnalysisParameters(hand=parameters.hand), _REST_MS, "A"),
        ReachPerception(AnalysisParameters(hand=parameters.hand_b), _REST_MS, "B"),
    )


def details(reach: ReachPerceived | None) -> Json:
    """Return the details stored with a reach; none if there was no reach."""
    if reach is None or reach.onset is None:
        return {}
    stored: Json = {name: reach.details.get(name) for name in _STORED}
    return stored | {"turn_ns": reach.turn, "movement_end_ns": reach.end}


def rehearsed(at_ms: float, performance: Performance, streams: RandomStreams) -> list[Act]:
    """Return a simulated reach from ``at_ms``: 20 cm and back, 1.1 s in a healthy adult. A slip is
    only a twitch.
    """
    from sar_tui.api.task import ReachShape

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

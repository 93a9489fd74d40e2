"""The rest from which a reach starts: the one just before the key that starts it."""

from sar_tui.motion import quaternions
from sar_tui.motion.changes import changes
from sar_tui.motion.filters import LEAST_RATE_HZ
from sar_tui.motion.grid import even
from sar_tui.motion.movement import order_statistic
from sar_tui.motion.orientation import OrientationParameters
from sar_tui.motion.rest import SLOW_HZ
from sar_tui.motion.samples import Samples, recording
from sar_tui.motion.segmenter import EARLY_S
from sar_tui.motion.vectors import lengths

SHORTEST_S = 0.1
"""A shorter rest is a turn."""


def home_since(samples: Samples, at: int, parameters: OrientationParameters) -> int | None:
    """Return when the hand came to the rest from which it starts at about ``at``; both in ns.

    None if the samples before that rest hold no movement that a detector could take for a part of
    the reach (it turned the hand by less than ``parameters.least_rad``), or if the hand did not
    rest.

    Args:
        samples: the newest samples, dtype SAMPLE.
        at: when the participant started the trial.
        parameters: definitions of rest and of a reach.
    """
    if len(samples) < 2:
        return None
    origin = int(samples["at"][0])
    grid = even(recording(samples, origin))
    if len(grid.time_s) < 2 or grid.rate_hz < LEAST_RATE_HZ:
        return None
    rest, rate, spectrum = grid.unbiased(parameters.rest_s)
    slow = lengths(spectrum.below(SLOW_HZ, rest.tremor_hz))
    still = slow <= max(parameters.end_rad_s, 1.2 * order_statistic(slow[rest.still], 0.99))
    edges = changes(still)
    at_s = (at - origin) / 1e9
    homes = [
        first
        for first, stop in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
        if stop - first >= SHORTEST_S * grid.rate_hz
        and grid.time_s[first] < at_s
        and grid.time_s[stop - 1] >= at_s - EARLY_S
    ]
    if not homes:
        return None
    orientation = quaternions.integrate(rate[: homes[-1] + 1], 1.0 / grid.rate_hz)
    turned = quaternions.angle(
        quaternions.multiply(quaternions.conjugate(orientation[-1]), orientation)
    )
    return (
        origin + round(float(grid.time_s[homes[-1]]) * 1e9)
        if turned.max() >= parameters.least_rad
        else None
    )

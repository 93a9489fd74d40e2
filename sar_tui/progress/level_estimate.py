"""The level at which a person would just reach the goal, estimated from the times of one session.

A rule that adapts the level keeps success, and so the results, near the goal: what changes with
progress is the level. Whether attempts succeeded says little of it, because they succeed at almost
every easy level and fail at almost every hard one. Their times say more. The distance of an
attempt's result from the goal is close to a straight line over the difficulty of its level: the
reaction time over the information in the choice (Hick 1952; Hyman 1953), the reach time over the
distance. The line crosses zero at the level at goal.

- The unit is the attempt, not the prompt: prompts of one attempt share what that minute was like,
  and a band made from prompts would be too narrow. Attempts weigh by the number of responses that
  their mean is made of.
- The slope comes from all attempts of a session, its height only from those after the run-in, which
  lie near the goal: while the level climbs, people also warm up, which flattens the line.
- Nothing is extrapolated: a session whose results are all on one side of the goal yields a bound.
"""

import math
from collections.abc import Sequence

import msgspec

from sar_tui.rules.student import t95

LARGEST_G = 0.3
"""A session's own slope is used if it is known this well: the square of the 95 % error of the slope
over the slope (Fieller's g). Otherwise that of all sessions is, and only without one again its own.
"""
ENDLESS_G = 0.7
"""From this g on the band says nothing: at 1 it has no end."""
FEWEST_SPARE = 2
"""Fewest degrees of freedom of a band."""
FEWEST_OF_DONOR = 6
"""Fewest degrees of freedom of a slope that takes part in the mean: those of fewer seem exact by
chance.
"""
FEWEST_NEAR_GOAL = 4
"""With fewer attempts after the run-in, the run-in is used too."""


class Attempt(msgspec.Struct, frozen=True):
    """An attempt that has a result.

    Args:
        difficulty: place of its level on the task's axis of difficulty.
        weight: number of responses that its result is the mean of; above 0.
        distance: of its result from the goal; positive if it is worse.
    """

    difficulty: float
    weight: float
    distance: float


class Slope(msgspec.Struct, frozen=True):
    """Growth of the distance from the goal with difficulty, the variance of its error, and its
    degrees of freedom.
    """

    value: float
    variance: float
    spare: int = 0


class Estimate(msgspec.Struct, frozen=True):
    """Difficulty at which the goal would just be reached, with its 95 % range.

    ``borrowed``: the slope is that of the person's other sessions.
    """

    value: float
    low: float
    high: float
    borrowed: bool = False


class _Line(msgspec.Struct, frozen=True):
    """Weighted means, and sums of squares and of products about them."""

    attempts: int
    weight: float
    x: float
    y: float
    xx: float
    xy: float
    yy: float


def _line(attempts: Sequence[Attempt]) -> _Line:
    """Return the sums of some attempts, in one pass: a report has thousands of sessions."""
    weight = x = y = xx = xy = yy = 0.0
    for each in attempts:
        w, d, e = each.weight, each.difficulty, each.distance
        weight += w
        x += w * d
        y += w * e
        xx += w * d * d
        xy += w * d * e
        yy += w * e * e
    x, y = x / weight, y / weight
    return _Line(
        attempts=len(attempts),
        weight=weight,
        x=x,
        y=y,
        xx=max(0.0, xx - weight * x * x),
        xy=xy - weight * x * y,
        yy=max(0.0, yy - weight * y * y),
    )


def brackets_goal(attempts: Sequence[Attempt]) -> bool:
    """Return True if results lie on both sides of the goal."""
    return any(each.distance < 0 for each in attempts) and any(
        each.distance >= 0 for each in attempts
    )


def near_goal(attempts: Sequence[Attempt]) -> Sequence[Attempt]:
    """Return the attempts after the run-in, which ends with the first result on the other side of
    the goal.

    That result itself is left out: it was waited for, so that its error is more likely of one sign.
    """
    side = attempts[0].distance < 0
    turn = next(
        (place for place, each in enumerate(attempts) if (each.distance < 0) != side), len(attempts)
    )
    return attempts[turn + 1 :] if len(attempts) - turn - 1 >= FEWEST_NEAR_GOAL else attempts


def slope_of(attempts: Sequence[Attempt]) -> Slope | None:
    """Return the slope of a session's line, however well it is known; None if all attempts were at
    one difficulty.
    """
    spare = len(attempts) - 2
    if spare < FEWEST_SPARE or (line := _line(attempts)).xx <= 1e-9 * line.weight:
        return None
    slope = line.xy / line.xx
    return Slope(slope, max(0.0, line.yy - slope * line.xy) / spare / line.xx, spare)


def is_well_known(slope: Slope) -> bool:
    """Return True if a slope rises, and is known well enough to be used alone."""
    return slope.value > 0 and t95(slope.spare) ** 2 * slope.variance <= LARGEST_G * slope.value**2


def shared_slope(slopes: Sequence[Slope]) -> Slope | None:
    """Return the slope to expect in a session: the mean of all, whose variance includes that
    between sessions.

    Slopes that are not well known take part, with less weight: to leave out those that seem flat
    would make the mean too steep. The variance between sessions is that of DerSimonian & Laird
    (1986).
    """
    slopes = [slope for slope in slopes if slope.spare >= FEWEST_OF_DONOR]
    if not slopes:
        return None
    floor = 1e-9 * sum(slope.value**2 for slope in slopes) / len(slopes)
    weights = [1 / max(slope.variance, floor) for slope in slopes]
    mean = _mean(slopes, weights)
    spread = sum(
        weight * (slope.value - mean) ** 2 for weight, slope in zip(weights, slopes, strict=True)
    )
    scale = sum(weights) - sum(weight**2 for weight in weights) / sum(weights)
    between = max(0.0, (spread - len(slopes) + 1) / scale) if len(slopes) > 1 else 0.0
    weights = [1 / (max(slope.variance, floor) + between) for slope in slopes]
    return Slope(_mean(slopes, weights), between + 1 / sum(weights))


def _mean(slopes: Sequence[Slope], weights: Sequence[float]) -> float:
    return sum(weight * slope.value for weight, slope in zip(weights, slopes, strict=True)) / sum(
        weights
    )


def level_at_goal(attempts: Sequence[Attempt], shared: Slope | None = None) -> Estimate | None:
    """Return the difficulty at which a session's line crosses the goal, with its band by Fieller's
    theorem (1954).

    Args:
        attempts: of one session, in order.
        shared: slope to use if the session's own is not well known.

    Returns:
        None if results lie on one side of the goal only, if there are too few, or the band says
        nothing.
    """
    if not brackets_goal(attempts):
        return None
    near, own = near_goal(attempts), slope_of(attempts)
    if own and is_well_known(own):
        return _crossing(near, own, len(near) - 2)
    borrowed = _crossing(near, shared, len(near) - 1) if shared else None
    if borrowed:
        return msgspec.structs.replace(borrowed, borrowed=True)
    return _crossing(near, own, len(near) - 2) if own else None


def _crossing(near: Sequence[Attempt], slope: Slope, spare: int) -> Estimate | None:
    """Return where a line of a given slope through attempts crosses the goal; None if it may never
    do so.
    """
    if slope.value <= 0 or spare < FEWEST_SPARE:
        return None
    line = _line(near)
    rest = max(0.0, line.yy - 2 * slope.value * line.xy + slope.value**2 * line.xx)
    t = t95(spare)
    of_mean, of_slope = t**2 * rest / spare / line.weight, t**2 * slope.variance
    if of_slope > ENDLESS_G * slope.value**2:
        return None
    divisor = slope.value**2 - of_slope
    middle = -slope.value * line.y / divisor
    half = (
        math.sqrt(max(0.0, slope.value**2 * of_mean + of_slope * (line.y**2 - of_mean))) / divisor
    )
    return Estimate(line.x - line.y / slope.value, line.x + middle - half, line.x + middle + half)

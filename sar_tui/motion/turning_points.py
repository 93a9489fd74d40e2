"""Turning points of a signal, except small wobbles."""

from collections.abc import Sequence


def turning_points(values: Sequence[float], swing: float) -> list[int]:
    """Return the indices of the extremes between which the signal moves by ``swing`` (above 0) or
    more, alternating.

    Smaller movements the other way belong to the swing that they interrupt. The first index is
    where the first swing starts, the last where the last swing ends; empty without a swing.
    """
    found: list[int] = []
    low = high = 0
    rising: bool | None = None
    for index, value in enumerate(values):
        if rising is not False and value > values[high]:
            high = index
        if rising is not True and value < values[low]:
            low = index
        if rising is not True and value - values[low] >= swing:
            found.append(low)
            rising, high = True, index
        elif rising is not False and values[high] - value >= swing:
            found.append(high)
            rising, low = False, index
    return [*found, high if rising else low] if found else found

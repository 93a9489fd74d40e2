"""Where a signal turns back, little wobbles apart."""

from collections.abc import Sequence


def turning_points(values: Sequence[float], swing: float) -> list[int]:
    """Indices of the extremes between which the signal moves by ``swing`` (more than 0) or more, high and low in turn.

    Smaller movements the other way are part of the swing they interrupt. The first is where the first swing starts,
    the last where the last one has come to; empty where nothing swings.
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

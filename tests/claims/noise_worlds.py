"""Worlds in which a person's attempts differ by noise alone, each in another way. More is better in
all of them.
"""

import math
import random
from collections.abc import Callable, Sequence
from functools import cache
from statistics import fmean

from sar_tui.rules.real_change import spread_of

Attempts = list[list[float]]
"""The trials of successive attempts. The SD of single trials within an attempt is about 1."""
World = Callable[[random.Random, int, int], Attempts]
"""Draws a number of attempts with a number of trials each."""

MOMENTS_SD = 0.7
"""SD between attempts, where they differ by more than their trials."""
KEPT = 0.8
"""Share of a drift that is left in the next attempt."""
SPOILT, WORSE_BY = 0.1, 4.0
"""Share of attempts that are spoilt, and by how much they are worse."""
SLIPS, SLIP = 0.03, 5.0
"""Share of trials that are slips, and by how much they are worse."""
_MANY = 20_000
_SESSION = 10


def _trials(
    draw: Callable[[], float], count: int, trials: int, shifts: Sequence[float] = ()
) -> Attempts:
    return [
        [draw() + (shifts[number] if shifts else 0.0) for _ in range(trials)]
        for number in range(count)
    ]


def normal(rng: random.Random, count: int, trials: int) -> Attempts:
    return _trials(lambda: rng.gauss(0, 1), count, trials)


def good_tail(rng: random.Random, count: int, trials: int) -> Attempts:
    """Now and then a trial is far better than the others."""
    return _trials(lambda: rng.lognormvariate(0, 0.6), count, trials)


def bad_tail(rng: random.Random, count: int, trials: int) -> Attempts:
    """Now and then a trial is far worse, as reaction times are."""
    return _trials(lambda: -rng.lognormvariate(0, 0.6), count, trials)


def heavy_tails(rng: random.Random, count: int, trials: int) -> Attempts:
    """Student's t with three degrees of freedom."""
    return _trials(lambda: rng.gauss(0, 1) / math.sqrt(rng.gammavariate(1.5, 2) / 3), count, trials)


def moments(rng: random.Random, count: int, trials: int) -> Attempts:
    """Each attempt has a better or worse moment of its own."""
    return _trials(
        lambda: rng.gauss(0, 1), count, trials, [rng.gauss(0, MOMENTS_SD) for _ in range(count)]
    )


def drift(rng: random.Random, count: int, trials: int) -> Attempts:
    """The moments come and go slowly."""
    shifts = [rng.gauss(0, MOMENTS_SD)]
    while len(shifts) < count:
        shifts.append(KEPT * shifts[-1] + rng.gauss(0, MOMENTS_SD * math.sqrt(1 - KEPT**2)))
    return _trials(lambda: rng.gauss(0, 1), count, trials, shifts)


def spoilt_attempts(rng: random.Random, count: int, trials: int) -> Attempts:
    shifts = [-WORSE_BY * (rng.random() < SPOILT) for _ in range(count)]
    return _trials(lambda: rng.gauss(0, 1), count, trials, shifts)


def slips(rng: random.Random, count: int, trials: int) -> Attempts:
    return _trials(lambda: rng.gauss(0, 1) - SLIP * (rng.random() < SLIPS), count, trials)


WORLDS: dict[str, World] = {
    "normal": normal,
    "good tail": good_tail,
    "bad tail": bad_tail,
    "heavy tails": heavy_tails,
    "moments": moments,
    "drift": drift,
    "spoilt": spoilt_attempts,
    "slips": slips,
}


@cache
def sem(world: str, trials: int) -> float:
    """Return the true standard error of measurement of a world: the SD between the means of its
    attempts.
    """
    rng = random.Random(f"{world} {trials}")
    played = [WORLDS[world](rng, _SESSION, trials) for _ in range(_MANY // _SESSION // trials)]
    return spread_of([fmean(attempt) for session in played for attempt in session])

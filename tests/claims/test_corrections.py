"""A correction is rare by chance, whatever the noise, and comes soon after a true decline."""

import random
from statistics import fmean

import pytest

from sar_tui.rules.decline import decline
from tests.claims.noise_worlds import WORLDS, sem
from tests.examples import first

ATTEMPTS = 20
"""Attempts of a session without change."""
SESSIONS = 150
DECLINES = 600
SDS = 3.0
"""Decline of one measure that must be found, in SD of the person's attempts; it lasts."""
EARLIER = 15
"""Attempts before the first that is worse."""
WITHIN = 3
"""Attempts within which it must be found, the first that is worse included."""
SETTLED_WORLDS = [world for world in WORLDS if world not in ("drift", "spoilt")]
"""Worlds in which attempts differ by no more than chance."""


@pytest.mark.parametrize("world", first(1, WORLDS))
@pytest.mark.parametrize("trials", [1, 5])
@pytest.mark.parametrize("measures", [1, 4])
def test_at_most_one_attempt_in_twenty_is_corrected_if_nothing_has_changed(
    world: str, trials: int, measures: int
) -> None:
    rng = random.Random(f"{world} {measures} {trials}")
    corrected = 0
    for _ in range(SESSIONS):
        drawn = [means_of(world, rng, ATTEMPTS, trials) for _ in range(measures)]
        corrected += sum(
            any(decline(means[:attempt], "higher", measures=measures) for means in drawn)
            for attempt in range(1, ATTEMPTS + 1)
        )
    assert corrected / (SESSIONS * ATTEMPTS) <= 0.05


@pytest.mark.parametrize("world", first(1, SETTLED_WORLDS))
@pytest.mark.parametrize("trials", [1, 5])
@pytest.mark.parametrize("measures", [1, 3])
def test_a_lasting_decline_by_three_sd_is_named_within_three_attempts(
    world: str, trials: int, measures: int
) -> None:
    rng = random.Random(f"{world} {measures} {trials} {EARLIER}")
    named = 0
    by = SDS * sem(world, trials)
    for _ in range(DECLINES):
        means = means_of(world, rng, EARLIER + WITHIN, trials)
        worse = [mean - by * (number >= EARLIER) for number, mean in enumerate(means)]
        named += any(
            decline(worse[: EARLIER + more], "higher", measures=measures)
            for more in range(1, WITHIN + 1)
        )
    assert named / DECLINES >= 0.9


def means_of(world: str, rng: random.Random, count: int, trials: int) -> list[float]:
    return [fmean(attempt) for attempt in WORLDS[world](rng, count, trials)]

"""Progress over sessions: simulated histories, whose true level at goal is known, against their
estimates.
"""

import math
import random
from statistics import fmean

import msgspec
import pytest

from sar_tui.progress import change
from sar_tui.progress.level_estimate import (
    Attempt,
    Estimate,
    level_at_goal,
    near_goal,
    shared_slope,
    slope_of,
)
from sar_tui.simulation.participant_model import PEOPLE, Person

HISTORIES = 700
"""Histories of each user; three users make more than 2,000."""
SESSIONS, ATTEMPTS, PROMPTS = 8, 20, 20
GOAL_MS = 1000.0
CHOICES = (2, 4, 6, 8, 12, 19, 26, 36, 46, 56)
PEOPLE_SD = 0.1
"""SD of the logarithm of a person's times about those of their kind."""
COVERAGE = (0.93, 0.97)
MOST_CHANGED = 0.05


class Model(msgspec.Struct, frozen=True):
    """A world in which histories are played. The estimates know nothing of it.

    Args:
        day_sd_ms: SD of all times from day to day.
        attempt_sd_ms: SD of the mean time from attempt to attempt.
        curve_ms: added for each squared bit away from three bits.
        practice: share of the times that repeated testing saves, and the sessions after which 63 %
            of it is saved.
        recovery: share of the times saved after the baseline.
    """

    day_sd_ms: float = 30.0
    attempt_sd_ms: float = 0.0
    curve_ms: float = 0.0
    practice: tuple[float, float] = (0.1, 2.0)
    recovery: float = 0.0


MODELS: dict[str, Model] = {
    "only practice": Model(),
    "attempts vary": Model(attempt_sd_ms=30.0),
    "curved times": Model(curve_ms=20.0),
    "slow practice": Model(practice=(0.1, 4.0)),
    "20 % faster": Model(recovery=0.2),
}


class _Day(msgspec.Struct, frozen=True):
    """A simulated session: its attempts, the true level at goal in bits, and the level it ended
    at.
    """

    attempts: list[Attempt]
    truth: float
    last: int


class Findings(msgspec.Struct):
    """Bands of histories with the true level at goal of each, and verdicts on last sessions."""

    bands: list[tuple[Estimate, float]] = []
    verdicts: list[str] = []

    def covered(self) -> float:
        """Return the share of bands that hold the true level at goal."""
        return fmean(band.low <= truth <= band.high for band, truth in self.bands)

    def bias_bits(self) -> float:
        return fmean(band.value - truth for band, truth in self.bands)

    def changed(self) -> float:
        """Return the share of known verdicts that say that the person changed."""
        known = [verdict for verdict in self.verdicts if verdict != "not yet known"]
        return fmean(verdict in ("more", "less") for verdict in known)


@pytest.mark.slow
def test_bands_hold_the_truth_and_practice_is_no_change_in_over_two_thousand_histories() -> None:
    found = [findings("only practice", user, HISTORIES) for user in PEOPLE]
    bands = [band for each in found for band in each.bands]
    low, high = COVERAGE
    assert low <= Findings(bands).covered() <= high
    assert max(each.changed() for each in found) <= MOST_CHANGED


@pytest.mark.parametrize("model", MODELS)
def test_bands_hold_the_truth_in_a_few_histories_of_every_world(model: str) -> None:
    found = findings(model, "average", 12)
    assert found.covered() > 0.85
    assert abs(found.bias_bits()) < 0.15


def findings(model: str, user: str, histories: int) -> Findings:
    """Play histories of a user in a world, and estimate the level at goal of each session."""
    rng, found = random.Random(f"{model} {user}"), Findings()
    for _ in range(histories):
        days = _history(rng, MODELS[model], PEOPLE[user])
        shared = shared_slope([slope for day in days if (slope := slope_of(day.attempts))])
        bands = [level_at_goal(day.attempts, shared) for day in days]
        found.bands += [(band, day.truth) for band, day in zip(bands, days, strict=True) if band]
        values = [band.value for band in bands if band]
        if values:
            found.verdicts.append(change.verdict(values[-1], change.baseline(values)))
    return found


def _history(rng: random.Random, model: Model, kind: Person) -> list[_Day]:
    """Play the sessions of one person, each from the level at which the last one ended."""
    person = msgspec.structs.replace(
        kind,
        base_ms=kind.base_ms * rng.lognormvariate(0, PEOPLE_SD),
        per_bit_ms=kind.per_bit_ms * rng.lognormvariate(0, PEOPLE_SD),
    )
    days: list[_Day] = []
    for session in range(SESSIONS):
        gain, sessions = model.practice
        factor = 1 + gain * math.exp(-session / sessions)
        if session >= change.FAMILIARISATION + change.BASELINE:
            factor *= 1 - model.recovery
        days.append(_day(rng, model, person, factor, days[-1].last if days else 1))
    return days


def _day(rng: random.Random, model: Model, person: Person, factor: float, level: int) -> _Day:
    day_ms = rng.gauss(0, model.day_sd_ms)
    attempts: list[Attempt] = []
    slowed: list[float] = []
    for number in range(1, ATTEMPTS + 1):
        bits = math.log2(CHOICES[level - 1])
        slowed.append(factor * person.mean_ms(1, number) / person.mean_ms(1, 1))
        right = max(1, sum(rng.random() >= person.errors for _ in range(PROMPTS)))
        # The mean of ex-Gaussian times is a normal part and a gamma-distributed one.
        noise = rng.gauss(0, person.sigma_ms / math.sqrt(right)) - person.tau_ms
        noise += rng.gammavariate(right, person.tau_ms / right) + rng.gauss(0, model.attempt_sd_ms)
        mean = slowed[-1] * _unslowed(model, person, bits) + day_ms + noise
        attempts.append(Attempt(bits, right, mean - GOAL_MS))
        level = min(len(CHOICES), level + 1) if mean < GOAL_MS else max(1, level - 1)
    pace = fmean(slowed[len(attempts) - len(near_goal(attempts)) :])
    return _Day(attempts, _truth(model, person, (GOAL_MS - day_ms) / pace), level)


def _unslowed(model: Model, person: Person, bits: float) -> float:
    return person.base_ms + person.per_bit_ms * bits + model.curve_ms * (bits - 3) ** 2


def _truth(model: Model, person: Person, goal_ms: float) -> float:
    """Return the bits at which the mean time is the goal. Times grow from 2 bits on, also in a
    curve.
    """
    low, high = -4.0, 12.0
    if model.curve_ms:
        low = 3 - person.per_bit_ms / model.curve_ms / 2
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if _unslowed(model, person, middle) < goal_ms else (low, middle)
    return (low + high) / 2

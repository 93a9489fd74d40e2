"""Progress over sessions: simulated histories, whose true level at goal is known, against their
estimates.
"""

import math
import random
from collections.abc import Sequence
from statistics import fmean
from typing import Any

import msgspec
import pytest

from sar_tui.progress import change
from sar_tui.progress.level_estimate import (
    Attempt,
    Estimate,
    brackets_goal,
    level_at_goal,
    near_goal,
    shared_slope,
    slope_of,
)
from sar_tui.simulation.participant_model import PEOPLE, Person

Row = dict[str, Any]
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
        is_fitted: True if times grow in a straight line, as the estimates assume.
        day_sd_ms: SD of all times from day to day.
        attempt_sd_ms: SD of the mean time from attempt to attempt.
        curve_ms: added for each squared bit away from three bits.
        practice: share of the times that repeated testing saves, and the sessions after which 63 %
            of it is saved.
        recovery: share of the times saved after the baseline.
    """

    is_fitted: bool = True
    day_sd_ms: float = 30.0
    attempt_sd_ms: float = 0.0
    curve_ms: float = 0.0
    practice: tuple[float, float] = (0.1, 2.0)
    recovery: float = 0.0


MODELS: dict[str, Model] = {
    "only practice": Model(),
    "attempts vary": Model(is_fitted=False, attempt_sd_ms=30.0),
    "curved times": Model(is_fitted=False, curve_ms=20.0),
    "slow practice": Model(is_fitted=False, practice=(0.1, 4.0)),
    "20 % faster": Model(is_fitted=False, recovery=0.2),
}
FITTED = tuple(name for name, model in MODELS.items() if model.is_fitted)


class _Day(msgspec.Struct, frozen=True):
    """A simulated session: its attempts, the true level at goal in bits, and the level it ended
    at.
    """

    attempts: list[Attempt]
    truth: float
    last: int


@pytest.mark.slow
def test_bands_hold_the_truth_and_practice_is_no_change_in_over_two_thousand_histories() -> None:
    rows = [row_of(name, user, HISTORIES) for name in FITTED for user in PEOPLE]
    assert sum(row["histories"] for row in rows) >= 2000
    low, high = COVERAGE
    assert low <= covered(rows) <= high
    assert max(row["changed"] for row in rows) <= MOST_CHANGED


@pytest.mark.parametrize("model", MODELS)
def test_bands_hold_the_truth_in_a_few_histories_of_every_world(model: str) -> None:
    row = row_of(model, "average", 12)
    assert row["coverage"] > 0.85
    assert abs(row["bias_bits"]) < 0.15


def test_a_band_that_is_too_narrow_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sar_tui.progress.level_estimate.t95", lambda df: 0.5)
    assert covered([row_of("only practice", "average", 12)]) < COVERAGE[0]


def test_a_verdict_without_students_t_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sar_tui.progress.change.t95", lambda df: 0.5)
    assert max(row_of("only practice", user, 12)["changed"] for user in PEOPLE) > MOST_CHANGED


def covered(rows: Sequence[Row]) -> float:
    """Return the share of estimates whose band holds the true level at goal."""
    estimates = sum(row["estimates"] for row in rows)
    return sum(row["coverage"] * row["estimates"] for row in rows) / estimates


def row_of(name: str, user: str, count: int) -> Row:
    """Return the figures of some histories of a user in a world."""
    model, rng = MODELS[name], random.Random(f"{name} {user}")
    histories = [_history(rng, model, PEOPLE[user]) for _ in range(count)]
    found = [_estimates(days) for days in histories]
    pairs = [
        (estimate, day.truth)
        for days, estimates in zip(histories, found, strict=True)
        for day, estimate in zip(days, estimates, strict=True)
        if estimate
    ]
    verdicts = [_verdict([each.value for each in estimates if each]) for estimates in found]
    known = [verdict for verdict in verdicts if verdict != "not yet known"]
    days = [day for days in histories for day in days]
    return {
        "model": name,
        "user": user,
        "histories": len(histories),
        "sessions": len(days),
        "estimates": len(pairs),
        "one_sided": sum(not brackets_goal(day.attempts) for day in days) / len(days),
        "coverage": fmean(each.low <= truth <= each.high for each, truth in pairs),
        "bias_bits": fmean(each.value - truth for each, truth in pairs),
        "width_bits": fmean(each.high - each.low for each, _ in pairs),
        "judged": len(known),
        "changed": fmean(verdict in ("more", "less") for verdict in known) if known else None,
    }


def _estimates(days: Sequence[_Day]) -> list[Estimate | None]:
    shared = shared_slope([slope for day in days if (slope := slope_of(day.attempts))])
    return [level_at_goal(day.attempts, shared) for day in days]


def _verdict(values: Sequence[float]) -> str:
    found = change.baseline(values)
    return change.verdict(values[-1], found) if values else "not yet known"


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

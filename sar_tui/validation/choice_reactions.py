"""A simulated user's attempts at choice reactions, and the probability of success that each attempt
has of itself.

Reaction times are those of `simulation.participant_model`: ex-Gaussian about a mean that grows with
the logarithm of the number of keys. Practice and fatigue of the model are left out; instead a user
is at rest, or learns.
"""

import math
from bisect import bisect_left
from functools import lru_cache
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from sar_tui.model.messages import Outcome
from sar_tui.rules.difficulty.policy import ScoredAttempt
from sar_tui.simulation.participant_model import Person

PROMPTS = 20
LEAST_RIGHT = 16
"""Right responses that an attempt needs to succeed: 0.8 of them."""
LEARNT, LEARNING_ATTEMPTS = 0.35, 60
"""A learner's mean reaction time falls by this share, evenly over so many attempts."""

_NORMAL = NormalDist()


class User(NamedTuple):
    """A person who is at rest or learns, and the goal that their therapist has set: in ms."""

    person: Person
    learns: bool
    goal: float

    def mean(self, keys: int, attempt: int) -> float:
        """Return the mean reaction time among some keys in an attempt (0, 1, …), in ms."""
        learnt = LEARNT * min(1.0, attempt / LEARNING_ATTEMPTS) if self.learns else 0.0
        return self.person.mean_ms(keys, 1) * (1 - learnt)

    @property
    def right(self) -> float:
        """Probability of a right response to a prompt."""
        return 1 - self.person.errors - self.person.misses


class Chance(NamedTuple):
    """Deviations from the mean of an attempt's right responses in ms, sorted, and their mean."""

    deviations: list[float]
    mean: float

    def attempt(self, number: int, mean: float, goal: float) -> ScoredAttempt:
        """Return the attempt of a user with this mean reaction time, judged by this goal."""
        result = mean + self.mean if len(self.deviations) >= LEAST_RIGHT else None
        outcome: Outcome = "success" if result is not None and result < goal else "failure"
        return ScoredAttempt(
            number, outcome, result, bisect_left(self.deviations, goal - mean), PROMPTS
        )


def chances(user: User, attempts: int, seed: int) -> list[Chance]:
    """Draw what is left to chance in some attempts: the same under every policy."""
    person = user.person
    generator = np.random.default_rng([seed, *person.name.encode()])
    shape = (attempts, PROMPTS)
    times = generator.normal(-person.tau_ms, person.sigma_ms, shape) + generator.exponential(
        person.tau_ms, shape
    )
    is_right = generator.random(shape) < user.right
    rows = (sorted(row[right].tolist()) for row, right in zip(times, is_right, strict=True))
    return [Chance(row, sum(row) / len(row) if row else 0.0) for row in rows]


def prompt_success(user: User, margin: float) -> float:
    """Return the probability that a prompt is answered right, and in less than the mean plus
    ``margin`` (ms).
    """
    sigma, tau = user.person.sigma_ms, user.person.tau_ms
    above = margin + tau
    tail = math.exp(sigma**2 / (2 * tau**2) - above / tau) * _NORMAL.cdf(
        above / sigma - sigma / tau
    )
    return user.right * (_NORMAL.cdf(above / sigma) - tail)


def attempt_success(user: User, margin: float) -> float:
    """Return the probability that enough responses are right, and their mean below the user's plus
    ``margin`` (ms).

    The mean of so many reaction times is nearly normal; its skewness is corrected for (Edgeworth).
    """
    sigma, tau = user.person.sigma_ms, user.person.tau_ms
    sd = math.hypot(sigma, tau)
    found = 0.0
    for right, probability in _numbers_right(user.right):
        z = margin / sd * math.sqrt(right)
        skewness = 2 * tau**3 / sd**3 / math.sqrt(right)
        found += probability * (_NORMAL.cdf(z) - skewness / 6 * (z**2 - 1) * _NORMAL.pdf(z))
    return found


@lru_cache
def _numbers_right(right: float) -> tuple[tuple[int, float], ...]:
    """Return the numbers of right responses that are enough, each with its probability."""
    numbers = range(LEAST_RIGHT, PROMPTS + 1)
    return tuple(
        (n, math.comb(PROMPTS, n) * right**n * (1 - right) ** (PROMPTS - n)) for n in numbers
    )

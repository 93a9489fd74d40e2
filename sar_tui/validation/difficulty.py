"""Difficulty policies: how often simulated users succeed, and how many of their attempts are a
fitting challenge.

An attempt fits if its own probability of success, given its level and its goal, lies between 0.6
and 0.8. A rate of success near 0.7 can also come from sure successes and sure failures in turn.
"""

import math
from bisect import bisect_left
from collections.abc import Sequence
from functools import lru_cache
from statistics import NormalDist, fmean, pstdev
from typing import Any, NamedTuple

import numpy as np

from sar_tui.model.messages import Outcome
from sar_tui.model.trial_types import Metric
from sar_tui.rules import level_choice
from sar_tui.rules.difficulty import ScoredAttempt
from sar_tui.rules.parameters import build
from sar_tui.simulation.participant_model import PEOPLE, Person
from sar_tui.validation.report import Claim, Column, Conditions, Report, Row
from sar_tui.validation.simulated_sessions import TASK

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


SESSIONS, QUICK_SESSIONS = 200, 40
"""Sessions of each user under each policy."""
ATTEMPTS, COUNTED = 160, 40
"""Number of attempts of each user, and of the last ones that the figures are about: a learner has
learnt by then.
"""
GOAL_KEYS = 6
"""A user's goal is their mean reaction time among so many keys when they begin."""
FITTING = (0.6, 0.8)

POLICIES: dict[str, dict[str, object]] = {
    "one-up-one-down": {"difficulty_policy": "one-up-one-down"},
    "fixed": {"difficulty_policy": "fixed", "start_level": GOAL_KEYS - 1},
    "target": {"difficulty_policy": "target"},
    "target (attempts)": {"difficulty_policy": "target", "target_of": "attempts"},
    "percentile": {"difficulty_policy": "percentile", "start_level": GOAL_KEYS - 1},
    "sequence": {
        "difficulty_policy": "sequence",
        "level_sequence": [level for level in range(1, 17) for _ in range(ATTEMPTS // 16)],
    },
}
"""Settings of each policy; the level with six keys is the fifth. ``sequence``: one level up after
ten attempts.
"""


class Counted(NamedTuple):
    """An attempt that counts: its level, its own probability of success, and the share of successes
    in it.
    """

    level: int
    expected: float
    success: float


def run(conditions: Conditions) -> Report:
    """Return one row for each policy, user, and state: at rest, and learning."""
    kind = conditions.catalogue.task(TASK)
    levels = build(kind.Parameters, {}).chosen_levels()  # type: ignore[attr-defined]
    rows = compare(
        [len(level.keys) for level in levels],
        kind.metric,
        kind.Parameters,
        conditions,
        range(1, 1 + (QUICK_SESSIONS if conditions.is_quick else SESSIONS)),
    )
    return Report(rows, [_COLUMNS], claims(rows))


def compare(
    keys: Sequence[int],
    metric: Metric,
    parameters: Any,
    conditions: Conditions,
    seeds: Sequence[int],
) -> list[Row]:
    """Return the rows for a task with so many keys at each level."""
    rows: list[Row] = []
    for person in PEOPLE.values():
        for learns in (False, True):
            user = User(person, learns, person.mean_ms(GOAL_KEYS, 1))
            drawn = [chances(user, ATTEMPTS, seed) for seed in seeds]
            for name, settings in POLICIES.items():
                conditions.progress(
                    f"difficulty: {name}", len(rows), 2 * len(PEOPLE) * len(POLICIES)
                )
                set_up = build(parameters, settings)
                sessions = [
                    play(user, keys, metric, set_up, by_chance)[-COUNTED:] for by_chance in drawn
                ]
                rows.append(
                    {
                        "policy": name,
                        "user": person.name,
                        "learning": learns,
                        **_figures(sessions, len(keys)),
                    }
                )
    return sorted(rows, key=lambda row: list(POLICIES).index(row["policy"]))


def play(
    user: User, keys: Sequence[int], metric: Metric, parameters: Any, by_chance: Sequence[Chance]
) -> list[Counted]:
    """Return a user's attempts under the policy in ``parameters``."""
    of_prompts = parameters.difficulty_policy == "target" and parameters.target_of == "prompts"
    state = level_choice.start(parameters, len(keys))
    past: dict[int, list[float | None]] = {}
    played = []
    for number, chance in enumerate(by_chance, 1):
        own = level_choice.goal(past.get(state.level, ()), metric, parameters)
        goal = own.value if own else user.goal
        mean = user.mean(keys[state.level - 1], number - 1)
        attempt = chance.attempt(number, mean, goal)
        if of_prompts:
            counted = Counted(
                state.level, prompt_success(user, goal - mean), attempt.reached / attempt.prompts
            )
        else:
            counted = Counted(
                state.level, attempt_success(user, goal - mean), float(attempt.outcome == "success")
            )
        played.append(counted)
        past.setdefault(state.level, []).append(attempt.result)
        state = level_choice.step(state, attempt, parameters, len(keys))
    return played


def _figures(sessions: Sequence[Sequence[Counted]], levels: int) -> Row:
    counted = [attempt for session in sessions for attempt in session]
    low, high = FITTING
    return {
        "success_rate": round(fmean(attempt.success for attempt in counted), 4),
        "fitting": round(fmean(low <= attempt.expected <= high for attempt in counted), 4),
        "level_sd": round(
            fmean(pstdev(attempt.level for attempt in session) for session in sessions), 4
        ),
        "at_bound": round(fmean(attempt.level in (1, levels) for attempt in counted), 4),
    }


def claims(rows: Sequence[Row]) -> list[Claim]:
    """Return what the policies promise, tested on the rows."""
    one_up = [row for row in rows if row["policy"] == "one-up-one-down"]
    fitting = [row for row in rows if row["policy"] in ("target", "percentile")]
    return [
        Claim(
            "one-up-one-down: about half of the attempts succeed (0.45 to 0.55).",
            _against(one_up, 0.45, 0.55),
        ),
        Claim(
            "target: 7 of 10 prompts reach the goal; percentile: 7 of 10 attempts do (0.65 to "
            "0.75).",
            _against(fitting, 0.65, 0.75),
        ),
        Claim(
            "target and percentile: at least 7 of 10 attempts are fitting.",
            "; ".join(
                f"{_who(row)}: {row['fitting']:.2f}" for row in fitting if row["fitting"] < 0.7
            ),
        ),
    ]


def _against(rows: Sequence[Row], low: float, high: float) -> str:
    off = [row for row in rows if not low <= row["success_rate"] <= high]
    return "; ".join(f"{_who(row)}: {row['success_rate']:.2f}" for row in off)


def _who(row: Row) -> str:
    return f"{row['policy']}, {row['user']}{', learning' if row['learning'] else ''}"


_COLUMNS = [
    Column("policy", lambda row: str(row["policy"]), is_number=False),
    Column("user", lambda row: str(row["user"]), is_number=False),
    Column("", lambda row: "learning" if row["learning"] else "at rest", is_number=False),
    Column("success", lambda row: f"{row['success_rate']:.2f}"),
    Column("fitting", lambda row: f"{row['fitting']:.2f}"),
    Column("SD of level", lambda row: f"{row['level_sd']:.2f}"),
    Column("at a bound", lambda row: f"{row['at_bound']:.2f}"),
]

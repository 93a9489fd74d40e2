"""A model of one person's responses in a session, fitted to its trials.

The mean reaction time grows in a straight line with the information in the choice, log2 n bits
(Hick 1952; Hyman 1953), and in a straight line over the attempts. Responses scatter about it in
proportion to it (Wagenmakers & Brown 2007), with the shape that they had: the ratios of recorded
and mean times are drawn again. Attempts scatter, too, as far as theirs differ by more than their
trials explain. Slips and misses are equally likely in all prompts.
"""

import math
from collections import defaultdict
from collections.abc import Sequence
from random import Random
from typing import NamedTuple

import msgspec
import numpy as np
import numpy.typing as npt

from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import Performance

FEWEST_RESPONSES = 20
"""Correct responses below which no model is fitted."""
FEWEST_ATTEMPTS = 2
FASTEST_MS = 100.0
"""The least time that is drawn: a faster response would be an anticipation."""
_PER_BIT_MS = (150.0, 100.0)
"""Time for each bit of choice as it is assumed before a trial is looked at: mean and standard
deviation of published slopes (Proctor & Schneider 2018). It decides only if the session had few
levels.
"""
_TREND_SHARE = 0.01
"""Standard deviation assumed of the change of the mean from attempt to attempt, as a share of
it.
"""

Floats = npt.NDArray[np.float64]


class Response(NamedTuple):
    """A correct response: in which attempt, to a prompt among how many, and after how many ms."""

    attempt: int
    choices: int
    reaction_ms: float


class Counts(NamedTuple):
    """Numbers of prompts and of those that were missed or answered wrongly; of offers of feedback,
    and requests.
    """

    prompts: int
    missed: int
    wrong: int
    offered: int = 0
    asked: int = 0


class Fit(msgspec.Struct, frozen=True):
    """The coefficients that were found, and how well they fit.

    Attributes:
        responses: number of correct responses with a time.
        attempts: number of attempts with one.
        fewest_choices, most_choices: range of the choices: beyond it, the model extrapolates.
        base_ms: mean reaction time without a choice, in the middle of the session.
        per_bit_ms: its growth with each bit of choice.
        per_attempt_ms: its change from attempt to attempt.
        spread: standard deviation of the responses, as a share of their mean.
        attempt_spread: the same of attempts, beyond what their responses explain.
        explained: share of the variance of the recorded times that the mean explains.
        missed, wrong, asked: shares of prompts and of offers of feedback.
    """

    responses: int
    attempts: int
    fewest_choices: int
    most_choices: int
    base_ms: float
    per_bit_ms: float
    per_attempt_ms: float
    spread: float
    attempt_spread: float
    explained: float
    missed: float
    wrong: float
    asked: float | None


class ResponseModel:
    """The model of one person.

    Args:
        responses: at least `FEWEST_RESPONSES`, of at least `FEWEST_ATTEMPTS` attempts.
        counts: of the same trials.
    """

    def __init__(self, responses: Sequence[Response], counts: Counts) -> None:
        self._counts = counts
        self._first = min(one.attempt for one in responses)
        self._last = max(one.attempt for one in responses)
        self._middle = float(np.mean([one.attempt for one in responses]))
        design = np.array([self._row(one.choices, one.attempt) for one in responses])
        times = np.array([one.reaction_ms for one in responses])
        usual = times.mean()
        prior = np.array([usual, _PER_BIT_MS[0], 0.0])
        precision = np.diag(
            [(4 * usual) ** -2.0, _PER_BIT_MS[1] ** -2.0, (_TREND_SHARE * usual) ** -2.0]
        )
        mean, inflation, self._attempt_sd = np.full(len(times), usual), np.ones(len(times)), 0.0
        variance = float(np.var(times / usual, ddof=1))
        for _ in range(4):  # the scatter depends on the mean, and the mean on the scatter
            weights = 1 / (variance * mean**2 * inflation)
            self._covariance = np.linalg.inv(precision + design.T @ (design * weights[:, None]))
            self._middle_values = self._covariance @ (
                precision @ prior + design.T @ (weights * times)
            )
            mean = np.maximum(design @ self._middle_values, FASTEST_MS)
            ratios = times / mean
            self._attempt_sd, inflation, variance = _scatter(
                ratios, [one.attempt for one in responses]
            )
        self._ratios = ratios / ratios.mean()
        bits = self._middle_values
        levels = [one.choices for one in responses]
        self.fit = Fit(
            responses=len(responses),
            attempts=len({one.attempt for one in responses}),
            fewest_choices=min(levels),
            most_choices=max(levels),
            base_ms=float(bits[0]),
            per_bit_ms=float(bits[1]),
            per_attempt_ms=float(bits[2]),
            spread=math.sqrt(variance),
            attempt_spread=self._attempt_sd,
            explained=float(1 - np.var(times - mean) / np.var(times)) if np.var(times) else 0.0,
            missed=counts.missed / counts.prompts,
            wrong=counts.wrong / counts.prompts,
            asked=counts.asked / counts.offered if counts.offered else None,
        )

    def _row(self, choices: int, attempt: int) -> tuple[float, float, float]:
        return 1.0, math.log2(max(1, choices)), self._trend(attempt)

    def _trend(self, attempt: int) -> float:
        """Return how far an attempt is from the middle; the trend goes on no further than the
        recorded attempts.
        """
        return min(max(attempt, self._first), self._last) - self._middle

    def draw(self, seed: int) -> "DrawnPerson":
        """Draw a person who may as well have made the recorded responses."""
        generator = np.random.default_rng(seed)
        counts = self._counts
        size = len(self._ratios)
        ratios = self._ratios[generator.integers(size, size=size)]
        return DrawnPerson(
            model=self,
            seed=seed,
            values=generator.multivariate_normal(self._middle_values, self._covariance),
            ratios=[float(ratio) for ratio in ratios / ratios.mean()],
            attempt_sd=self._attempt_sd,
            missed=generator.beta(0.5 + counts.missed, 0.5 + counts.prompts - counts.missed),
            wrong=generator.beta(
                0.5 + counts.wrong, 0.5 + counts.prompts - counts.missed - counts.wrong
            ),
            asks=generator.beta(0.5 + counts.asked, 0.5 + counts.offered - counts.asked),
        )

    def mean_ms(self, values: Floats, choices: int, attempt: int) -> float:
        """Return the mean reaction time under values of the three coefficients."""
        base, per_bit, per_attempt = values
        return float(
            base + per_bit * math.log2(max(1, choices)) + per_attempt * self._trend(attempt)
        )


class DrawnPerson:
    """One person drawn from a model, who performs as `simulation.participant` asks."""

    def __init__(
        self,
        model: ResponseModel,
        seed: int,
        values: Floats,
        ratios: Sequence[float],
        attempt_sd: float,
        missed: float,
        wrong: float,
        asks: float,
    ) -> None:
        self._model = model
        self._seed = seed
        self._values = values
        self._ratios = ratios
        self._attempt_sd = attempt_sd
        self._missed = missed
        self._wrong = wrong
        self._asks = asks
        self._factors: dict[tuple[int, int], float] = {}

    def perform(self, choices: int, attempt: int, streams: RandomStreams) -> Performance:
        """Draw the performance of one prompt among ``choices`` in an attempt (1, 2, …)."""
        if (choices, attempt) not in self._factors:
            mean = self._model.mean_ms(self._values, choices, attempt)
            shift = Random(f"{self._seed}/{attempt}").gauss(0, self._attempt_sd)
            self._factors[choices, attempt] = mean * (1 + shift)
        drawn = self._factors[choices, attempt] * streams.choice(self._ratios, "ratio")
        return Performance(max(FASTEST_MS, drawn), slips=streams.uniform("slip") < self._wrong)

    def misses_it(self, streams: RandomStreams) -> bool:
        """Return True if this prompt gets no response."""
        return streams.uniform("miss") < self._missed

    def wants_feedback(self, streams: RandomStreams) -> bool:
        """Return True if they request feedback on an attempt."""
        return streams.uniform("ask") < self._asks


def _scatter(ratios: Floats, attempts: Sequence[int]) -> tuple[float, Floats, float]:
    """Split the scatter of responses into that of attempts and that within them (analysis of
    variance).

    Returns:
        The standard deviation of attempts, for each response the factor by which it counts less
        because those of an
        attempt go together, and the variance within attempts.
    """
    groups: dict[int, list[float]] = defaultdict(list)
    for ratio, attempt in zip(ratios, attempts, strict=True):
        groups[attempt].append(float(ratio))
    means = {attempt: float(np.mean(group)) for attempt, group in groups.items()}
    free = max(1, len(ratios) - len(groups))
    within = (
        sum((ratio - means[attempt]) ** 2 for attempt, group in groups.items() for ratio in group)
        / free
    )
    within = within or 1e-6
    size = len(ratios) / len(groups)
    between = sum(len(groups[attempt]) * (mean - 1) ** 2 for attempt, mean in means.items()) / max(
        1, len(groups) - 1
    )
    variance = max(0.0, (between - within) / size)
    inflation = np.array([1 + len(groups[attempt]) * variance / within for attempt in attempts])
    return math.sqrt(variance), inflation, within

"""A staircase that weighs all answers: each prompt is put where the threshold most likely is, given
them.

After Watson and Pelli (1983), Percept. Psychophys. 33, 113-120: the observer's share of right
answers is a Weibull function of known slope, whose place is unknown; Bayes' rule gives the
probability of each place on a grid. The next prompt is at its mean, rather than at its mode
(King-Smith et al. 1994, Vision Res. 34, 885-912).
"""

import math
from collections.abc import Sequence
from functools import cache
from itertools import accumulate
from typing import Literal, NamedTuple

import msgspec


class Estimate(NamedTuple):
    """The threshold, as far as it is known: mean and standard deviation, in the unit of the
    values.
    """

    mean: float
    sd: float


class Quest(msgspec.Struct, frozen=True, kw_only=True):
    """An adaptive estimate of the value at which a share of the answers is right: a pure function
    of the answers.

    Values are on a grid from ``lowest`` to ``highest``. For a physical intensity, let them be its
    logarithm to base 10: with a ``slope`` of 8 the function is then the Weibull function of
    exponent 3.5 that Watson and Pelli use.

    Args:
        lowest, highest: bounds of values and threshold.
        grain: the distance of neighbouring values.
        start: the first guess of the threshold.
        spread: the standard deviation of this guess: large, if little is known.
        slope: of the observer's function, per unit of the values.
        target: the share of right answers at the threshold.
        guesses: the share of right answers of an observer who sees nothing: 1 / number of choices.
        lapses: the share of wrong answers of one who sees everything.
        harder: the direction in which prompts become harder.

    Raises:
        ValueError: the numbers make no grid, or no observer has the target.
    """

    lowest: float
    highest: float
    grain: float
    start: float
    spread: float
    slope: float
    target: float = 0.75
    guesses: float = 0.5
    lapses: float = 0.02
    harder: Literal["lower", "higher"] = "lower"

    def __post_init__(self) -> None:
        if not (self.lowest < self.highest and 0 < self.grain <= self.highest - self.lowest):
            raise ValueError(
                "the values go from the lowest to the highest by their grain, which is above 0"
            )
        if self.spread <= 0 or self.slope <= 0:
            raise ValueError("the spread and the slope are above 0")
        if not 0 <= self.guesses < self.target < 1 - self.lapses <= 1:
            raise ValueError(
                "the target is above the share of guesses, and below that of an observer who lapses"
            )

    @property
    def values(self) -> tuple[float, ...]:
        """The values of the grid, lowest first."""
        return _values(self)

    def next(self, answers: Sequence[bool]) -> float:
        """Return the value of the next prompt, from the answers so far: True for a right one."""
        return self.values[_nearest(self, self.posterior(answers))]

    def estimate(self, answers: Sequence[bool]) -> Estimate:
        """Return the threshold, from the answers so far."""
        return _estimate(self, self.posterior(answers))

    def posterior(self, answers: Sequence[bool]) -> tuple[float, ...]:
        """Return the probability of each value of the grid to be the threshold, from the answers so
        far.
        """
        steps = accumulate(
            answers, lambda before, is_right: _updated(self, before, is_right), initial=_prior(self)
        )
        *_, last = steps
        return last


@cache
def _values(quest: Quest) -> tuple[float, ...]:
    number = math.floor((quest.highest - quest.lowest) / quest.grain + 1e-9) + 1
    return tuple(quest.lowest + place * quest.grain for place in range(number))


@cache
def _prior(quest: Quest) -> tuple[float, ...]:
    return _normed(
        [math.exp(-(((value - quest.start) / quest.spread) ** 2) / 2) for value in _values(quest)]
    )


@cache
def _right(quest: Quest) -> tuple[float, ...]:
    """Return the share of right answers by the distance of a prompt from the threshold, in places
    of the grid.

    The middle one is for no distance; prompts become harder from the first to the last.
    """
    number = len(_values(quest))
    sees = (quest.target - quest.guesses) / (1 - quest.guesses - quest.lapses)
    at_threshold = math.log(-math.log1p(-sees))
    return tuple(
        _share(quest, at_threshold - quest.slope * place * quest.grain)
        for place in range(1 - number, number)
    )


def _share(quest: Quest, log_strength: float) -> float:
    seen = -math.expm1(-math.exp(min(log_strength, 50.0)))
    return quest.guesses + (1 - quest.guesses - quest.lapses) * seen


def _updated(quest: Quest, before: tuple[float, ...], is_right: bool) -> tuple[float, ...]:
    """Return the probabilities after one more answer, to the prompt that they led to."""
    place, number = _nearest(quest, before), len(before)
    shares = _right(quest)
    first = number - 1 - place if quest.harder == "lower" else number - 1 + place
    towards = 1 if quest.harder == "lower" else -1
    likely = [shares[first + towards * threshold] for threshold in range(number)]
    return _normed(
        [
            was * (share if is_right else 1 - share)
            for was, share in zip(before, likely, strict=True)
        ]
    )


def _nearest(quest: Quest, posterior: Sequence[float]) -> int:
    mean = _estimate(quest, posterior).mean
    return max(0, min(round((mean - quest.lowest) / quest.grain), len(posterior) - 1))


def _estimate(quest: Quest, posterior: Sequence[float]) -> Estimate:
    values = _values(quest)
    mean = sum(value * share for value, share in zip(values, posterior, strict=True))
    variance = sum(
        (value - mean) ** 2 * share for value, share in zip(values, posterior, strict=True)
    )
    return Estimate(mean, math.sqrt(variance))


def _normed(weights: Sequence[float]) -> tuple[float, ...]:
    whole = sum(weights)
    return tuple(weight / whole for weight in weights)

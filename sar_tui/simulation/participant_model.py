"""Models of participants: reaction times, errors, practice and fatigue, drawn from seeded random
streams.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from random import Random
from typing import Any, NamedTuple

import msgspec

from sar_tui.model.messages import TrialEnded
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import Act, Performance, Stimulus


class Person(msgspec.Struct, frozen=True):
    """A model of a person at a choice-reaction task.

    Reaction times are ex-Gaussian (Luce 1986; Heathcote, Popiel & Mewhort 1991): a normal part and
    an exponential tail of mean ``tau_ms``. Their mean grows with the information in a choice among
    n stimuli, log2 n bits (Hick 1952; Hyman 1953), shrinks with practice towards an asymptote, and
    grows with fatigue.

    Args:
        name: ``poor``, ``average``, ``competent``.
        base_ms: mean reaction time without a choice.
        per_bit_ms: added to the mean for each bit of choice.
        sigma_ms: standard deviation of the normal part.
        tau_ms: mean of the exponential tail, part of the mean.
        errors: share of prompts with a wrong response.
        misses: share of prompts without a response.
        practice: share of the reaction time that practice saves in the end.
        practice_attempts: number of attempts after which practice saves 63 % of that.
        fatigue: share of the reaction time that each attempt adds.
        pace: duration of movements as a share of a healthy adult's.
        pace_sd: standard deviation of the logarithm of ``pace`` from movement to movement.
        unsteadiness: 0 for a hand that moves straight, 1 for one that halts and dwells.
        hand: tremor and sensor placement: one of `motion.synthesis.PROFILES`.
        lean_deg: median angle by which the trunk leans forward in a reach.
        asks: share of attempts after which they request feedback, if it is given on request.
    """

    name: str
    base_ms: float
    per_bit_ms: float
    sigma_ms: float
    tau_ms: float
    errors: float
    misses: float
    practice: float = 0.04
    practice_attempts: float = 5.0
    fatigue: float = 0.001
    pace: float = 1.0
    pace_sd: float = 0.05
    unsteadiness: float = 0.0
    hand: str = "steady"
    lean_deg: float = 4.0
    asks: float = 0.35

    def perform(self, choices: int, attempt: int, streams: RandomStreams) -> Performance:
        """Draw the performance of one prompt among ``choices`` in an attempt (1, 2, …)."""
        return Performance(
            reaction_ms=self.reaction_ms(choices, attempt, streams),
            slips=self.slips(streams),
            pace=lambda: self._drawn_pace(attempt, streams),
            unsteadiness=self.unsteadiness,
        )

    def _drawn_pace(self, attempt: int, streams: RandomStreams) -> float:
        varied = math.exp(streams.generator("pace", self.name).gauss(0, self.pace_sd))
        return self.pace * varied * self._slowed(attempt)

    def mean_ms(self, choices: int, attempt: int) -> float:
        """Return the mean reaction time among ``choices`` stimuli in an attempt (1, 2, …)."""
        return (self.base_ms + self.per_bit_ms * math.log2(max(1, choices))) * self._slowed(attempt)

    def _slowed(self, attempt: int) -> float:
        """Return the factor by which practice and fatigue change a time."""
        learnt = self.practice * (1 - math.exp(-(attempt - 1) / self.practice_attempts))
        return 1 - learnt + self.fatigue * (attempt - 1)

    def reaction_ms(self, choices: int, attempt: int, streams: RandomStreams) -> float:
        """Draw a reaction time of at least 120 ms, the fastest possible choice."""
        generator = streams.generator("reaction", self.name)
        return max(
            120.0,
            ex_gaussian(generator, self.mean_ms(choices, attempt), self.sigma_ms, self.tau_ms),
        )

    def misses_it(self, streams: RandomStreams) -> bool:
        """Return True if this prompt gets no response."""
        return streams.uniform("miss", self.name) < self.misses

    def slips(self, streams: RandomStreams) -> bool:
        """Return True if the response to this prompt is wrong."""
        return streams.uniform("slip", self.name) < self.errors

    def wants_feedback(self, streams: RandomStreams) -> bool:
        """Return True if they request feedback on an attempt."""
        return streams.uniform("ask", self.name) < self.asks


PEOPLE = {
    person.name: person
    for person in (
        Person(
            "poor",
            600,
            205,
            150,
            230,
            errors=0.06,
            misses=0.015,
            pace=1.45,
            pace_sd=0.12,
            unsteadiness=0.6,
            hand="patient",
            lean_deg=16.0,
        ),
        Person(
            "average",
            415,
            168,
            110,
            140,
            errors=0.03,
            misses=0.005,
            pace=1.16,
            pace_sd=0.08,
            unsteadiness=0.2,
        ),
        Person(
            "competent",
            310,
            129,
            90,
            120,
            errors=0.02,
            misses=0.001,
            practice=0.1,
            practice_attempts=6.0,
            fatigue=0.002,
            pace=0.9,
            pace_sd=0.05,
            lean_deg=2.0,
        ),
    )
}
"""The poor, average and competent users of the thesis."""


# --- differences between people and between their sessions


MEAN_MS, PERSON_SD_MS = 388.0, 39.0
"""Mean reaction time to one of four keys at 18 to 25 years (Deary, Liewald & Nissan 2011,
10.3758/s13428-010-0024-1), and the standard deviation of people's own means. With those of sessions
and trials below, 40 trials have the standard deviation of 45 ms between people that was published.
"""
SESSION_SD_MS = 20.0
"""Standard deviation of a person's sessions around their own mean. With 40 trials it makes the
correlation of two sessions .75, that of weekly retests (.72 to .77; 10.3389/fnhum.2015.00595).
"""
TRIAL_SD_MS = 69.0
"""Standard deviation of trials in a session (Deary, Liewald & Nissan 2011)."""


def drawn(person: Person, seed: int) -> Person:
    """Return a person who differs from a model as people do: faster or slower by a factor.

    The factor has the mean 1, and the coefficient of variation of reaction times between people, so
    that slower people differ by more milliseconds.
    """
    return _faster_or_slower(person, PERSON_SD_MS, RandomStreams(seed, "population"), "person")


def in_session(person: Person, seed: int) -> Person:
    """Return a person as they are in one of their sessions: each has a factor of its own."""
    return _faster_or_slower(person, SESSION_SD_MS, RandomStreams(seed, "population"), "session")


def population(n: int, seed: int, person: Person = PEOPLE["average"]) -> list[Person]:
    """Return ``n`` people who differ. The first ones of a larger population are the same."""
    streams = RandomStreams(seed, "people")
    return [drawn(person, streams.generator(number).getrandbits(63)) for number in range(n)]


def _faster_or_slower(person: Person, sd_ms: float, streams: RandomStreams, name: str) -> Person:
    factor = max(_FASTEST, streams.generator(name).gauss(1.0, sd_ms / MEAN_MS))
    return msgspec.structs.replace(
        person, base_ms=person.base_ms * factor, per_bit_ms=person.per_bit_ms * factor
    )


_FASTEST = 0.5
"""Least factor: five standard deviations below the mean."""


def ex_gaussian(generator: Random, mean: float, sigma: float, tau: float) -> float:
    """Draw the sum of a normal part with standard deviation ``sigma`` and an exponential tail with
    mean ``tau``.

    ``mean`` is that of the sum.
    """
    return generator.gauss(mean - tau, sigma) + generator.expovariate(1 / tau)


# --- an effect


Rehearsal = Callable[[Any, Stimulus, Performance, RandomStreams], list[Act]]
"""The acts of a simulated participant on a prompt: the task, then as `Task.rehearse`."""


class Effect(NamedTuple):
    """A published effect, and how it is found in a session. ``effect.py`` defines one, named
    ``EFFECT``.

    Attributes:
        title: what it is, in a few words: "incongruent minus congruent".
        unit: of the value.
        low, high: the published range of means.
        source: of that range.
        measure: returns the value of a session from its trials; None if it has none.
        without: what `Task.rehearse` returns for people who do not show the effect: the control.
        settings: of the sessions that are simulated.
    """

    title: str
    unit: str
    low: float
    high: float
    source: str
    measure: Callable[[Sequence[TrialEnded]], float | None]
    without: Rehearsal
    settings: Mapping[str, Any] = {}


def mean_time(trials: Sequence[TrialEnded]) -> float | None:
    """Return the mean reaction time of correct trials, ms; None without any."""
    times = [
        trial.reaction_time_ms
        for trial in trials
        if trial.correct and trial.reaction_time_ms is not None
    ]
    return sum(times) / len(times) if times else None

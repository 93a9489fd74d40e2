"""How a person reacts: times, errors, practice, fatigue. Pure, and seeded by what is asked."""

import math

import msgspec

from sar_tui.framework.chance import Chance


class Person(msgspec.Struct, frozen=True):
    """A model of someone at a choice-reaction task.

    Reaction times are ex-Gaussian (Luce 1986; Heathcote, Popiel & Mewhort 1991): a normal part and an
    exponential tail of mean ``tau_ms``. Their mean grows with the information in a choice among n stimuli,
    log2 n bits (Hick 1952; Hyman 1953), shrinks with practice towards an asymptote, and grows with fatigue.

    Args:
        name: what it is called: ``poor``, ``average``, ``competent``.
        base_ms: mean reaction time with no choice to make.
        per_bit_ms: what each bit of choice adds to it.
        sigma_ms: standard deviation of the normal part.
        tau_ms: mean of the exponential tail, part of the mean.
        errors: the share of prompts answered wrongly.
        misses: the share of prompts not answered.
        practice: the share of the reaction time that practice takes off in the end.
        practice_attempts: after so many attempts, 63 % of that.
        fatigue: the share of the reaction time that each attempt adds.
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

    def mean_ms(self, choices: int, attempt: int) -> float:
        """The mean reaction time among ``choices`` stimuli in an attempt (1, 2, …)."""
        learnt = self.practice * (1 - math.exp(-(attempt - 1) / self.practice_attempts))
        tired = self.fatigue * (attempt - 1)
        return (self.base_ms + self.per_bit_ms * math.log2(max(1, choices))) * (1 - learnt + tired)

    def reaction_ms(self, choices: int, attempt: int, chance: Chance) -> float:
        """One reaction time; never below 120 ms, the fastest a choice can be."""
        generator = chance.generator("reaction", self.name)
        normal = generator.gauss(self.mean_ms(choices, attempt) - self.tau_ms, self.sigma_ms)
        return max(120.0, normal + generator.expovariate(1 / self.tau_ms))

    def misses_it(self, chance: Chance) -> bool:
        """Whether this prompt is not answered."""
        return chance.uniform("miss", self.name) < self.misses

    def slips(self, chance: Chance) -> bool:
        """Whether this prompt is answered wrongly."""
        return chance.uniform("slip", self.name) < self.errors


PEOPLE = {
    person.name: person
    for person in (
        Person("poor", base_ms=560, per_bit_ms=205, sigma_ms=150, tau_ms=200, errors=0.05, misses=0.015),
        Person("average", base_ms=415, per_bit_ms=168, sigma_ms=110, tau_ms=140, errors=0.03, misses=0.005),
        Person("competent", base_ms=310, per_bit_ms=137, sigma_ms=70, tau_ms=100, errors=0.02, misses=0.001),
    )
}
"""The thesis' poor and competent users, and its typical average one."""

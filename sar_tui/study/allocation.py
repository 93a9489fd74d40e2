"""Allocation of people to groups, and to orders of conditions.

Everything random follows from a secret that stands in neither the plan nor the database, and from
the number of the draw: who has both cannot tell the next assignment, and a draw that was cut off
gives the same result when it is done again.
"""

import hashlib
import hmac
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TypeVar

import msgspec

from sar_tui.model.language import Sentence
from sar_tui.study.plan import Allocation

T = TypeVar("T")
_BYTES = 8


class AllocationError(Exception):
    """Nobody can be allocated. The message is one sentence."""


class Assigned(msgspec.Struct, frozen=True, kw_only=True):
    """An assignment of the ledger.

    Attributes:
        group: that the person came to.
        stratum: site and values of the factors, in words.
        factors: the same by name, for minimisation.
    """

    group: str
    stratum: str = ""
    factors: Mapping[str, str] = {}


class ListedGroup(msgspec.Struct, frozen=True):
    """A row of a list that was made elsewhere: the group of the next person of a stratum."""

    group: str
    stratum: str = ""


class Draws:
    """Random numbers that follow from a secret and from what they are drawn for.

    HMAC-SHA-256 of the labels: without the secret they cannot be told from random ones.
    """

    def __init__(self, secret: bytes) -> None:
        self._secret = secret

    @property
    def commitment(self) -> str:
        """SHA-256 of the secret, which is published with the plan: later it proves that the secret
        is the same.
        """
        return hashlib.sha256(b"sar-tui study " + self._secret).hexdigest()

    def uniform(self, *labels: object) -> float:
        """Return a number, 0 <= number < 1."""
        message = "\0".join(map(str, labels)).encode()
        digest = hmac.new(self._secret, message, hashlib.sha256).digest()[:_BYTES]
        return (int.from_bytes(digest, "big") >> 11) / (1 << 53)

    def choice(self, weights: Mapping[str, float], *labels: object) -> str:
        """Return one of the keys of ``weights``, with probabilities in their proportion."""
        point = self.uniform(*labels) * sum(weights.values())
        for name, weight in weights.items():
            point -= weight
            if point < 0:
                return name
        return list(weights)[-1]

    def shuffled(self, values: Sequence[T], *labels: object) -> list[T]:
        """Return the values in a random order (Fisher and Yates)."""
        mixed = list(values)
        for last in range(len(mixed) - 1, 0, -1):
            other = int(self.uniform(*labels, last) * (last + 1))
            mixed[last], mixed[other] = mixed[other], mixed[last]
        return mixed


def assign(
    given: Allocation,
    weights: Mapping[str, int],
    draws: Draws,
    before: Sequence[Assigned],
    stratum: str,
    factors: Mapping[str, str] | None = None,
    listed: Sequence[ListedGroup] = (),
) -> str:
    """Return the group of the next person.

    Args:
        given: how people are allocated.
        weights: of the groups, by name.
        draws: from the study's secret.
        before: all earlier assignments of this site, in order.
        stratum, factors: of this person.
        listed: the list, if there is one.

    Raises:
        AllocationError: the list has no further row of the stratum.
    """
    same = [one.group for one in before if one.stratum == stratum]
    number = len(same)
    match given.method:
        case "simple":
            return draws.choice(weights, "group", stratum, number)
        case "blocks":
            return _of_block(given, weights, draws, stratum, number)
        case "big stick":
            return _big_stick(given, weights, draws, stratum, same)
        case "minimisation":
            return _minimised(given, weights, draws, before, factors or {})
    rows = [row.group for row in listed if row.stratum == stratum]
    if number >= len(rows):
        used = len(rows)
        said = (
            Sentence(
                "The list has no further row for {stratum}: all {count} are used.",
                stratum=stratum,
                count=used,
            )
            if stratum
            else Sentence("The list has no further row: all {count} are used.", count=used)
        )
        raise AllocationError(said)
    return rows[number]


def sizes(given: Allocation, weights: Mapping[str, int]) -> tuple[int, ...]:
    """Return the sizes of blocks: those of the plan, else two, three and four times the weights."""
    return given.sizes or tuple(sum(weights.values()) * times for times in (2, 3, 4))


def _of_block(
    given: Allocation, weights: Mapping[str, int], draws: Draws, stratum: str, number: int
) -> str:
    possible = {str(size): 1 for size in sizes(given, weights)}

    def size_of(block: int) -> int:
        return int(draws.choice(possible, "size", stratum, block))

    block, first = 0, 0
    while number >= first + size_of(block):
        first += size_of(block)
        block += 1
    times = size_of(block) // sum(weights.values())
    groups = [name for name, weight in weights.items() for _ in range(weight * times)]
    return draws.shuffled(groups, "block", stratum, block)[number - first]


def _big_stick(
    given: Allocation,
    weights: Mapping[str, int],
    draws: Draws,
    stratum: str,
    same: Sequence[str],
) -> str:
    counts = Counter(same)
    smaller, larger = sorted(weights, key=lambda name: counts[name])
    if counts[larger] - counts[smaller] >= given.largest_difference:
        return smaller
    return draws.choice(weights, "group", stratum, len(same))


def _minimised(
    given: Allocation,
    weights: Mapping[str, int],
    draws: Draws,
    before: Sequence[Assigned],
    factors: Mapping[str, str],
) -> str:
    """Return the group with which the groups differ least over the levels of the factors that this
    person has: the sum of the ranges, as Pocock and Simon (1975, Biometrics 31:103-115).
    """

    def imbalance(group: str) -> float:
        total = 0.0
        for factor, value in factors.items():
            counts = Counter(one.group for one in before if one.factors.get(factor) == value)
            counts[group] += 1
            shares = [counts[name] / weight for name, weight in weights.items()]
            total += max(shares) - min(shares)
        return total

    found = {group: imbalance(group) for group in weights}
    least = min(found.values())
    best = {name: weight for name, weight in weights.items() if found[name] <= least + 1e-9}
    others = {name: weight for name, weight in weights.items() if name not in best}
    number = len(before)
    follows = not others or draws.uniform("follows", number) < given.certainty
    return draws.choice(best if follows else others, "group", number)


def row_of_order(draws: Draws, rows: int, number: int, *labels: str) -> int:
    """Return which of the orders of some conditions the next person gets: each once before any
    twice.

    Args:
        draws: from the study's secret.
        rows: number of orders.
        number: of people who have one already, in the same group and stratum.
        labels: what the order is of.
    """
    return draws.shuffled(range(rows), "order", *labels, number // rows)[number % rows]


def neutral_codes(draws: Draws, names: Sequence[str], letter: str) -> dict[str, str]:
    """Return codes that say nothing, "C1", "C2", …, by the names that they stand for."""
    mixed = draws.shuffled(sorted(names), "codes", letter)
    return {name: f"{letter}{number}" for number, name in enumerate(mixed, 1)}

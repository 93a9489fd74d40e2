"""Allocation: balanced as the design says, and not to be guessed from plan, database and code."""

import hashlib
from collections import Counter
from collections.abc import Callable
from random import Random

import pytest

from sar_tui.study.allocation import (
    AllocationError,
    Assigned,
    Draws,
    ListedGroup,
    assign,
    neutral_codes,
    row_of_order,
    sizes,
)
from sar_tui.study.plan import Allocation

GROUPS = {"a": 1, "b": 1}
DRAWS = 10_000
SECRET = bytes(range(32))


def groups(
    given: Allocation, number: int, draws: Draws, weights: dict[str, int] = GROUPS
) -> list[str]:
    """Return the groups of the first people of one stratum."""
    found: list[Assigned] = []
    for _ in range(number):
        found.append(Assigned(group=assign(given, weights, draws, found, "")))
    return [one.group for one in found]


def test_blocks_are_balanced_whatever_their_sizes() -> None:
    given = Allocation(method="blocks", sizes=(4, 6))
    for seed in range(50):
        found = groups(given, 60, Draws(seed.to_bytes(32, "big")))
        counts = Counter[str]()
        largest = 0
        for group in found:
            counts[group] += 1
            largest = max(largest, abs(counts["a"] - counts["b"]))
        assert largest <= 3
    assert sizes(Allocation(), {"a": 2, "b": 1}) == (6, 9, 12)


def test_weights_are_kept_in_each_block() -> None:
    found = groups(Allocation(method="blocks", sizes=(3,)), 30, Draws(SECRET), {"a": 2, "b": 1})
    for first in range(0, 30, 3):
        assert sorted(found[first : first + 3]) == ["a", "a", "b"]


def test_the_big_stick_never_lets_the_groups_differ_by_more() -> None:
    found = groups(Allocation(method="big stick", largest_difference=2), 400, Draws(SECRET))
    counts = Counter[str]()
    differences = []
    for group in found:
        counts[group] += 1
        differences.append(abs(counts["a"] - counts["b"]))
    assert max(differences) == 2
    forced = sum(before == 2 for before in differences[:-1])
    assert 0.2 < forced / 399 < 0.35  # a random walk between reflecting walls: one in four


def test_minimisation_balances_each_factor() -> None:
    given = Allocation(
        method="minimisation", strata={"age": ("young", "old"), "side": ("left", "right")}
    )
    random, draws = Random(1), Draws(SECRET)
    before: list[Assigned] = []
    for _ in range(200):
        factors = {"age": random.choice(("young", "old")), "side": random.choice(("left", "right"))}
        group = assign(given, GROUPS, draws, before, "|".join(factors.values()), factors)
        before.append(Assigned(group=group, factors=factors))
    for factor, value in (("age", "young"), ("age", "old"), ("side", "left"), ("side", "right")):
        counts = Counter(one.group for one in before if one.factors[factor] == value)
        assert abs(counts["a"] - counts["b"]) <= 6
    assert 60 <= Counter(one.group for one in before)["a"] <= 140


def test_each_order_comes_once_before_any_comes_twice() -> None:
    draws = Draws(SECRET)
    found = [row_of_order(draws, 4, number, "a|b", "g") for number in range(16)]
    for first in range(0, 16, 4):
        assert sorted(found[first : first + 4]) == [0, 1, 2, 3]
    assert found != 4 * found[:4]


def test_a_list_made_elsewhere_is_used_in_its_order_by_stratum() -> None:
    given = Allocation(method="list")
    rows = [ListedGroup("a", "x"), ListedGroup("b", "y"), ListedGroup("b", "x")]
    before = [Assigned(group="a", stratum="x")]
    assert assign(given, GROUPS, Draws(SECRET), before, "x", listed=rows) == "b"
    assert assign(given, GROUPS, Draws(SECRET), before, "y", listed=rows) == "b"
    before = [Assigned(group="b", stratum="y")]
    with pytest.raises(AllocationError, match="no further row for y"):
        assign(given, GROUPS, Draws(SECRET), before, "y", listed=rows)


DESIGNS = {
    "simple": Allocation(method="simple"),
    "blocks": Allocation(method="blocks", sizes=(4, 6, 8)),
    "big stick": Allocation(method="big stick", largest_difference=3),
}
PUBLIC = (
    b"",
    b"praise",
    bytes(32),
    hashlib.sha256(b"the plan").digest(),
    hashlib.sha256(b"sar-tui study ").digest(),
)
"""Keys that an attacker who has plan, database and code could take for the secret."""


@pytest.mark.slow
@pytest.mark.parametrize("design", DESIGNS)
def test_an_attacker_guesses_no_better_than_the_design_allows(design: str) -> None:
    """10,000 draws of 500 studies, guessed by the best known strategy (the group that is behind,
    Blackwell and Hodges 1957) and by keys that can be made from what is public. The design with
    real random numbers is beside it.
    """
    given = DESIGNS[design]
    each = 20

    def rate(key: Callable[[int], Draws], guess: Callable[[list[str], int], str]) -> float:
        right = 0
        for study in range(DRAWS // each):
            found = groups(given, each, key(study))
            right += sum(guess(found[:number], number) == found[number] for number in range(each))
        return right / DRAWS

    def behind(before: list[str], number: int) -> str:
        return min(GROUPS, key=lambda name: (before.count(name), name))

    random = Random(7)
    allowed = rate(lambda _: _RandomDraws(random), behind)
    secrets = [hashlib.sha256(f"secret {study}".encode()).digest() for study in range(DRAWS)]
    found = rate(lambda study: Draws(secrets[study]), behind)
    margin = 3 * (0.25 / DRAWS * 2) ** 0.5  # three standard errors of a difference
    assert abs(found - allowed) < margin
    for public in PUBLIC:
        guesses = groups(given, each, Draws(public))
        assert (
            rate(lambda study: Draws(secrets[study]), lambda before, n, g=guesses: g[n])  # type: ignore[misc]
            < 0.5 + margin
        )


class _RandomDraws(Draws):
    """Draws that no key decides, but that are the same when they are asked for again."""

    def __init__(self, random: Random) -> None:
        super().__init__(random.randbytes(32))
        self._random = random
        self._known: dict[tuple[object, ...], float] = {}

    def uniform(self, *labels: object) -> float:
        return self._known.setdefault(labels, self._random.random())


def test_neutral_codes_tell_nothing_of_the_order_of_names() -> None:
    firsts = Counter(
        neutral_codes(Draws(n.to_bytes(32, "big")), ["praise", "silence"], "C")["praise"]
        for n in range(400)
    )
    assert set(firsts) == {"C1", "C2"}
    assert 150 < firsts["C1"] < 250


def test_draws_are_uniform() -> None:
    draws = Draws(SECRET)
    found = [draws.uniform("x", n) for n in range(20_000)]
    assert min(found) >= 0
    assert max(found) < 1
    counts = Counter(int(value * 10) for value in found)
    chi2 = sum((count - 2000) ** 2 / 2000 for count in counts.values())
    assert chi2 < 27.9  # chi-squared with 9 degrees of freedom, p = .001

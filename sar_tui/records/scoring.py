"""Scores of forms: how the items of a form become a number, and what is done about missing ones."""

import math
from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple, Protocol

import msgspec


class Item(Protocol):
    """An item as a score needs it: with inclusive bounds, counted from the other end if it is
    reversed.
    """

    @property
    def name(self) -> str: ...
    @property
    def lowest(self) -> float: ...
    @property
    def highest(self) -> float: ...
    @property
    def reversed(self) -> bool: ...


class Score(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A score of a form, of all its items that are numbers, or of a subscale.

    Attributes:
        name: key of its value in the database.
        title: its name for people.
        items: numbers of its items, from 1; all if empty.
        rule: mean or sum of the items, after reversed ones are counted from the other end.
        subtract: from each item. ``times``: what the mean or the sum is multiplied by.
        missing: with a missing item there is ``no score``, or it counts as the ``middle`` of its
            scale, or as the mean of the ``others``.
        at_least: items that are answered, or there is no score.
        better: direction of improvement; empty if it has none.
    """

    name: str = "score"
    title: str = "Score"
    items: tuple[int, ...] = ()
    rule: Literal["mean", "sum"] = "mean"
    subtract: float = 0.0
    times: float = 1.0
    missing: Literal["no score", "middle", "others"] = "no score"
    at_least: int = 1
    better: Literal["higher", "lower", ""] = ""


class Computed(NamedTuple):
    """A score, None if too many items are missing, and the number of those."""

    value: float | None
    missing: int


def items_of(score: Score, items: Sequence[Item]) -> list[Item]:
    """Return the items of a score: of a form's items, those that are numbers with bounds."""
    if score.items:
        return [items[number - 1] for number in score.items]
    return [item for item in items if math.isfinite(item.lowest) and math.isfinite(item.highest)]


def compute(score: Score, items: Sequence[Item], values: Mapping[str, object]) -> Computed:
    """Return a score of a form.

    Args:
        score: its declaration.
        items: all items of the form, in order.
        values: the answers by item; an answer that is no number is missing.
    """
    own = items_of(score, items)
    answers = [(item, values.get(item.name)) for item in own]
    given = [_turned(item, value) for item, value in answers if isinstance(value, int | float)]
    missing = len(own) - len(given)
    if len(given) < max(1, score.at_least) or (missing and score.missing == "no score"):
        return Computed(None, missing)
    if score.missing == "middle":
        given += [
            (item.lowest + item.highest) / 2
            for item, value in answers
            if not isinstance(value, int | float)
        ]
    return Computed(_total(score, sum(given) / len(given), len(own)), missing)


def bounds(score: Score, items: Sequence[Item]) -> tuple[float, float]:
    """Return the lowest and the highest value that a score can have."""
    own = items_of(score, items)
    lowest, highest = [each.lowest for each in own], [each.highest for each in own]
    if score.missing == "others":  # any of them may be the only one that is answered
        ends = [min(lowest), max(highest)]
    else:
        ends = [sum(lowest) / len(own), sum(highest) / len(own)]
    low, high = sorted(_total(score, mean, len(own)) for mean in ends)
    return low, high


def _turned(item: Item, value: float) -> float:
    return item.lowest + item.highest - value if item.reversed else value


def _total(score: Score, mean: float, count: int) -> float:
    """Return the score of items with this mean."""
    total = (mean - score.subtract) * score.times
    return round(total * count if score.rule == "sum" else total, 6)


def problem(score: Score, items: Sequence[Item]) -> str:
    """Return why a score cannot be used, in one sentence; empty if it can."""
    if any(not 1 <= number <= len(items) for number in score.items):
        return f"The score {score.name} has items from 1 to {len(items)}."
    own = items_of(score, items)
    if not own or not all(
        math.isfinite(each.lowest) and math.isfinite(each.highest) for each in own
    ):
        return f"The items of the score {score.name} are numbers with lowest and highest."
    if len(set(score.items)) < len(score.items):
        return f"The score {score.name} names an item twice."
    if not 0 < score.at_least <= len(own):
        return f"The score {score.name} has {len(own)} items: at_least is 1 to {len(own)}."
    return ""

"""Staircases within an attempt: the value of the next prompt, from the answers so far.

A `Staircase` is a pure function of the answers, so a task needs no memory: it gives it those of
``situation.results``. After enough right answers in a row the next prompt is harder by a step,
after enough wrong ones easier, so that the values come to rest where a certain share of the answers
is right: `Staircase.target`.

One up, two down ends at 70.7 % (Levitt 1971, J. Acoust. Soc. Am. 49, 467-477); unequal steps, one
up and one down, at any share (Kaernbach 1991, Percept. Psychophys. 49, 227-229). `quest` has one
that weighs all answers.
"""

from collections.abc import Sequence
from typing import Literal

import msgspec

_BISECTIONS = 60


class Track(msgspec.Struct, frozen=True):
    """Values of a staircase so far. ``reversals``: those at which it turned round; ``next``: of the
    next prompt.
    """

    values: tuple[float, ...]
    reversals: tuple[float, ...]
    next: float


class Staircase(msgspec.Struct, frozen=True, kw_only=True):
    """A staircase that moves up after ``wrong`` wrong answers in a row, and down after ``right``
    right ones.

    Args:
        start: value of the first prompt.
        steps: a step towards the harder side, before the first reversal, after it, and so on; the
            last one stays.
        right: the number of right answers in a row after which prompts become harder.
        wrong: the number of wrong answers in a row after which they become easier.
        easier: a step to the easier side, as a multiple of one to the harder side.
        harder: the direction in which prompts become harder.
        lowest, highest: the bounds of the values.

    Raises:
        ValueError: the numbers make no staircase.
    """

    start: float
    steps: tuple[float, ...]
    right: int = 2
    wrong: int = 1
    easier: float = 1.0
    harder: Literal["lower", "higher"] = "lower"
    lowest: float = float("-inf")
    highest: float = float("inf")

    def __post_init__(self) -> None:
        if not self.steps or min(self.steps) <= 0 or self.easier <= 0:
            raise ValueError("a staircase needs one step or more, all above 0")
        if self.right < 1 or self.wrong < 1:
            raise ValueError("a staircase moves after one right and one wrong answer, or more")
        if not self.lowest <= self.start <= self.highest:
            raise ValueError(f"the start of a staircase ({self.start:g}) is outside its bounds")

    @property
    def target(self) -> float:
        """The share of right answers at which the values come to rest.

        A run of right answers must precede one of wrong ones as often as the steps balance.
        """
        down = self.easier / (1 + self.easier)
        low, high = 0.0, 1.0
        for _ in range(_BISECTIONS):
            middle = (low + high) / 2
            low, high = (middle, high) if self._goes_harder(middle) < down else (low, middle)
        return low

    def _goes_harder(self, share: float) -> float:
        """Return the probability of a run of right answers before one of wrong ones."""
        ups, downs = (1 - share) ** (self.wrong - 1), share ** (self.right - 1)
        return downs * (1 - (1 - share) ** self.wrong) / (downs + ups - downs * ups)

    def next(self, answers: Sequence[bool]) -> float:
        """Return the value of the next prompt, from the answers so far: True for a right one."""
        return self.track(answers).next

    def track(self, answers: Sequence[bool]) -> Track:
        """Return the values of all prompts so far, of the reversals among them, and of the next
        prompt.
        """
        value, values, reversals = self.start, [], []
        run, direction = 0, 0  # a run of right answers counts up, one of wrong answers down
        for is_right in answers:
            values.append(value)
            run = max(run, 0) + 1 if is_right else min(run, 0) - 1
            if run not in (self.right, -self.wrong):
                continue
            turn, run = (1 if run > 0 else -1), 0
            if direction == -turn:
                reversals.append(value)
            direction = turn
            value = self._moved(value, turn, len(reversals))
        return Track(tuple(values), tuple(reversals), value)

    def _moved(self, value: float, turn: int, reversals: int) -> float:
        step = self.steps[min(reversals, len(self.steps) - 1)] * (1 if turn > 0 else -self.easier)
        moved = value - step if self.harder == "lower" else value + step
        return max(self.lowest, min(moved, self.highest))

    def threshold(self, answers: Sequence[bool], reversals: int = 6) -> float | None:
        """Return the mean of the last reversals, an even number of them; None if there are not so
        many yet.
        """
        found = self.track(answers).reversals
        return sum(found[-reversals:]) / reversals if len(found) >= reversals else None


def weighted(
    target: float,
    *,
    start: float,
    steps: tuple[float, ...],
    harder: Literal["lower", "higher"] = "lower",
    lowest: float = float("-inf"),
    highest: float = float("inf"),
) -> Staircase:
    """Return a staircase of one up and one down whose steps balance at a share of right answers
    (Kaernbach 1991).

    Raises:
        ValueError: the share is not between 0 and 1, or the numbers make no staircase.
    """
    if not 0 < target < 1:
        raise ValueError(f"the target of a staircase is a share between 0 and 1, not {target:g}")
    easier = target / (1 - target)
    return Staircase(
        start=start,
        steps=steps,
        right=1,
        wrong=1,
        easier=easier,
        harder=harder,
        lowest=lowest,
        highest=highest,
    )

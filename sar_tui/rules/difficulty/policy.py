"""The parts of a difficulty policy."""

from collections.abc import Callable, Sequence
from typing import Any, Literal, NamedTuple

import msgspec

from sar_tui.model.messages import Outcome
from sar_tui.rules.declaration import Settings

MOST_RESULTS = 99
"""Largest number of results at a level that a goal may be made from."""


class Difficulty(msgspec.Struct, frozen=True):
    """The level of the next attempt.

    ``memory`` is the policy's own state. It is None at the start of a session and after an operator
    sets the level. ``why``: one plain sentence if the policy has just changed the level, else
    empty.
    """

    level: int
    memory: Any = None
    why: str = ""


class Goal(msgspec.Struct, frozen=True):
    """A goal that replaces the task's own, in the metric's unit, and why: one plain sentence."""

    value: float
    why: str


class Bounds(NamedTuple):
    """The lowest and the highest level, inclusive."""

    lowest: int
    highest: int

    def nearest(self, level: int) -> int:
        """Return the level within the bounds that is nearest to ``level``."""
        return max(self.lowest, min(level, self.highest))


class ScoredAttempt(NamedTuple):
    """An attempt as a difficulty policy sees it. Practice never gets here.

    With several seats, which share the level, the values are those of the seat that did worst.

    Attributes:
        number: 1 for the first of the session.
        outcome: success or failure.
        result: in the metric's unit; None if too few responses were right, or none could be timed.
        reached: number of prompts answered right, with a value better than the goal.
        prompts: number of all prompts.
    """

    number: int
    outcome: Outcome
    result: float | None = None
    reached: int = 0
    prompts: int = 0


def start_at(level: int, settings: Any, bounds: Bounds) -> int:
    """Return the level of the first attempt: the start level."""
    return min(level, bounds.highest)


def stay(state: Difficulty, attempt: ScoredAttempt, settings: Any, bounds: Bounds) -> Difficulty:
    """Return the difficulty unchanged."""
    return state


class DifficultyPolicy(NamedTuple):
    """A rule for the level of the next attempt, or for its goal.

    All functions must be pure: a resumed session computes them again. ``settings`` are the policy's
    own.

    Attributes:
        summary: one or two sentences for the therapist who chooses among the policies.
        settings: type of its settings.
        step: returns the difficulty after one more attempt, from the one before, within the bounds.
        goal: returns the goal of the next attempt, from the results so far at its level, oldest
            first (None for an attempt without one), and whether a lower or a higher one is better;
            None: the task's own. Without this function the goal is always the task's own.
        start: returns the level of the first attempt, from the start level, within the bounds.
    """

    summary: str
    settings: type[Settings] = Settings
    step: Callable[[Difficulty, ScoredAttempt, Any, Bounds], Difficulty] = stay
    goal: (
        Callable[[Sequence[float | None], Literal["lower", "higher"], Any], Goal | None] | None
    ) = None
    start: Callable[[int, Any, Bounds], int] = start_at

    @property
    def moves_level(self) -> bool:
        """True if the level follows the person, from the start level on."""
        return self.step is not stay and self.start is start_at

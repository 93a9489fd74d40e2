"""The level moves until a chosen share of the prompts, or of the attempts, reaches the goal.

Stochastic approximation (Robbins & Monro 1951): after each attempt the level moves by a step times
the distance of the share reached from the share wanted. The step shrinks when the direction turns
(Kesten 1958), so that a level far off is left quickly and a fitting one is kept, but never below a
floor, so that the level still follows a person who learns or tires.
"""

import math
from typing import Annotated, Literal, NamedTuple

from sar_tui.rules.declaration import Settings, meta
from sar_tui.rules.difficulty.policy import Bounds, Difficulty, DifficultyPolicy, ScoredAttempt

FIRST_STEP = 6.0
"""Step until the direction first turns, in levels for each 100 % of distance: three levels after
two perfect attempts with a target of 70 %.
"""


class TargetSettings(Settings, frozen=True, kw_only=True):
    """Settings of the difficulty policy ``target``."""

    target_share: Annotated[
        float,
        meta(
            "Target",
            "%",
            "For target: the share that should reach the goal.",
            ge=10,
            le=95,
            group="Difficulty",
        ),
    ] = 70.0
    target_of: Annotated[
        Literal["prompts", "attempts"],
        meta(
            "Target counts",
            help="For target: prompts answered right and better than the goal, or attempts that "
            "succeed. With one "
            "prompt in an attempt both are the same.",
            group="Difficulty",
        ),
    ] = "prompts"
    target_step: Annotated[
        float,
        meta(
            "Smallest step",
            "levels",
            "For target: the level moves by this times the distance from the target. More follows "
            "a person faster; "
            "less keeps the level stiller.",
            ge=0.1,
            le=20,
            group="Difficulty",
        ),
    ] = 2.0


class Place(NamedTuple):
    """A place between the levels, the direction of the last step (-1, 0 or 1), and how often it has
    turned.
    """

    place: float
    direction: int = 0
    turns: int = 0


def step(
    state: Difficulty, attempt: ScoredAttempt, settings: TargetSettings, bounds: Bounds
) -> Difficulty:
    """Return the difficulty after one more attempt: the level that is nearest to the new place."""
    before = state.memory or Place(state.level)
    aim = settings.target_share / 100
    off = _share(attempt, settings) - aim
    direction = (off > 0) - (off < 0)
    turns = before.turns + (direction * before.direction < 0)
    moved = before.place + max(settings.target_step, FIRST_STEP / (1 + turns)) * off
    place = max(float(bounds.lowest), min(moved, float(bounds.highest)))
    level = bounds.nearest(math.floor(place + 0.5))
    why = _why(attempt, settings) if level != state.level else ""
    return Difficulty(level, Place(place, direction or before.direction, turns), why)


def _share(attempt: ScoredAttempt, settings: TargetSettings) -> float:
    if settings.target_of == "attempts":
        return float(attempt.outcome == "success")
    return attempt.reached / max(1, attempt.prompts)


def _why(attempt: ScoredAttempt, settings: TargetSettings) -> str:
    target = f"the target is {settings.target_share:g} %"
    if settings.target_of == "attempts":
        return (
            f"Goal {'reached' if attempt.outcome == 'success' else 'missed'}; {target} of attempts."
        )
    return f"{attempt.reached} of {attempt.prompts} prompts reached the goal; {target}."


POLICY = DifficultyPolicy(
    "The level moves in small steps until a share of the prompts (70 %) reaches the goal.",
    TargetSettings,
    step,
)

"""Policies of difficulty: the level of the next attempt, or its goal.

First the parts of a policy, then the five that are included, each with its own settings. Settings
appear on the settings form of every task. Policies of others: docs/write-a-policy.md.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, Literal, NamedTuple

import msgspec
from msgspec import Meta

from sar_tui.model.language import Sentence
from sar_tui.model.messages import Outcome
from sar_tui.rules.declaration import Settings, in_group

setting = in_group("Difficulty")

BY_OUTCOME = "one-up-one-down"
"""The default policy. Each change of its level has the outcome of an attempt as its reason."""
_EXACT = 1e-6
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


def no_share(settings: Any) -> float:
    """Return 0: a policy that does not follow the person aims at no share of successes."""
    return 0.0


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
        title: a few words for the list of policies; empty: its name.
        aim: returns the share of attempts, 0 to 1, that succeed once level or goal fit the person;
            0: it aims at none. Without this function the preview of the settings says nothing of
            it.
    """

    summary: str
    settings: type[Settings] = Settings
    step: Callable[[Difficulty, ScoredAttempt, Any, Bounds], Difficulty] = stay
    goal: (
        Callable[[Sequence[float | None], Literal["lower", "higher"], Any], Goal | None] | None
    ) = None
    start: Callable[[int, Any, Bounds], int] = start_at
    title: str = ""
    aim: Callable[[Any], float] | None = None

    @property
    def moves_level(self) -> bool:
        """True if the level follows the person, from the start level on."""
        return self.step is not stay and self.start is start_at

    @property
    def ignores(self) -> tuple[str, ...]:
        """Settings of every task that have no effect under this policy."""
        return (
            *(() if self.start is start_at else ("start_level",)),
            *(() if self.moves_level else ("start_from",)),
            *(("min_level", "max_level") if self.step is stay else ()),
        )


class OneUpOneDownSettings(Settings, frozen=True, kw_only=True):
    """Settings of ``one-up-one-down``."""

    consecutive_successes: Annotated[
        int,
        setting(
            "Successes before harder",
            help="This many successes in a row raise the level by one.",
            ge=1,
            le=20,
        ),
    ] = 1
    consecutive_failures: Annotated[
        int,
        setting(
            "Misses before easier",
            help="This many missed goals in a row lower the level by one.",
            ge=1,
            le=20,
        ),
    ] = 1


class Streak(NamedTuple):
    """Attempts in a row with the same outcome since the level last changed."""

    outcome: Outcome
    length: int


def step_by_outcome(
    state: Difficulty, attempt: ScoredAttempt, settings: OneUpOneDownSettings, bounds: Bounds
) -> Difficulty:
    """Move one level up after N successes in a row, one down after M failures in a row (thesis
    4.2.1).

    With one of each, the level settles where half of the attempts succeed (Levitt 1971). If
    neighbouring levels are far apart, that half is one of sure successes and sure failures in turn.
    """
    before = state.memory
    streak = Streak(
        attempt.outcome, before.length + 1 if before and before.outcome == attempt.outcome else 1
    )
    if attempt.outcome == "success":
        needed, level, done = (
            settings.consecutive_successes,
            min(state.level + 1, bounds.highest),
            "reached",
        )
    else:
        needed, level, done = (
            settings.consecutive_failures,
            max(state.level - 1, bounds.lowest),
            "missed",
        )
    if streak.length < needed:
        return Difficulty(state.level, streak)
    times = f" {needed} times in a row" if needed > 1 else ""
    return Difficulty(level, why=f"Goal {done}{times}." if level != state.level else "")


def balance(settings: OneUpOneDownSettings) -> float:
    """Return the share of successes at which the level rises as often as it falls: 0.5 for one
    success and one failure, 0.71 for two successes and one failure (Levitt 1971).
    """
    up, down = settings.consecutive_successes, settings.consecutive_failures
    low, high = 0.0, 1.0
    while high - low > _EXACT:
        share = (low + high) / 2
        if _rises_first(share, up, down) < 0.5:
            low = share
        else:
            high = share
    return (low + high) / 2


def _rises_first(share: float, up: int, down: int) -> float:
    """Return the probability of ``up`` successes in a row before ``down`` failures in a row."""
    rises, falls = share ** (up - 1), (1 - share) ** (down - 1)
    return rises * (1 - (1 - share) ** down) / (rises + falls - rises * falls)


class SequenceSettings(Settings, frozen=True, kw_only=True):
    """Settings of ``sequence``."""

    level_sequence: Annotated[
        tuple[Annotated[int, Meta(ge=1, le=99)], ...],
        setting(
            "List of levels",
            help="The level of each attempt, such as 1 1 2 2 3. The last one stays.",
        ),
    ] = ()

    def problems(self) -> dict[str, str]:
        """Return an error if the policy is chosen, and the list is empty."""
        if getattr(self, "difficulty_policy", "") == "sequence" and not self.level_sequence:
            text = "Name the levels of the sequence, such as 1 1 2 2 3."
            return {"level_sequence": Sentence(text)}
        return {}


def start_of_list(level: int, settings: SequenceSettings, bounds: Bounds) -> int:
    """Return the first level of the list."""
    return bounds.nearest(settings.level_sequence[0])


def step_in_list(
    state: Difficulty, attempt: ScoredAttempt, settings: SequenceSettings, bounds: Bounds
) -> Difficulty:
    """Return the difficulty of the next place in the list; after its end, of the last."""
    levels = settings.level_sequence
    place = min(attempt.number, len(levels) - 1)
    level = bounds.nearest(levels[place])
    return Difficulty(
        level,
        why=f"Number {place + 1} of {len(levels)} in the list." if level != state.level else "",
    )


FIRST_STEP = 6.0
"""Step until the direction first turns, in levels for each 100 % of distance: three levels after
two perfect attempts with a target of 70 %.
"""


class TargetSettings(Settings, frozen=True, kw_only=True):
    """Settings of ``target``."""

    target_share: Annotated[
        float,
        setting(
            "Target",
            "%",
            "The share that should reach the goal.",
            ge=10,
            le=95,
        ),
    ] = 70.0
    target_of: Annotated[
        Literal["prompts", "attempts"],
        setting(
            "Target counts",
            help="Prompts answered right and better than the goal, or attempts that "
            "succeed. With one "
            "prompt in an attempt both are the same.",
        ),
    ] = "prompts"
    target_step: Annotated[
        float,
        setting(
            "Smallest step",
            "levels",
            "The level moves by this times the distance from the target. More follows "
            "a person faster; "
            "less keeps the level stiller.",
            ge=0.1,
            le=20,
        ),
    ] = 2.0


def target(settings: TargetSettings) -> float:
    """Return the share that should reach the goal."""
    return settings.target_share / 100


class Place(NamedTuple):
    """A place between the levels, the direction of the last step (-1, 0 or 1), and how often it has
    turned.
    """

    place: float
    direction: int = 0
    turns: int = 0


def step_to_target(
    state: Difficulty, attempt: ScoredAttempt, settings: TargetSettings, bounds: Bounds
) -> Difficulty:
    """Move the level until a chosen share of the prompts, or of the attempts, reaches the goal.

    Stochastic approximation (Robbins & Monro 1951): after each attempt the level moves by a step
    times the distance of the share reached from the share wanted. The step shrinks when the
    direction turns (Kesten 1958), so that a level far off is left quickly and a fitting one is
    kept, but never below a floor, so that the level still follows a person who learns or tires.
    """
    before = state.memory or Place(state.level)
    off = _share_reached(attempt, settings) - target(settings)
    direction = (off > 0) - (off < 0)
    turns = before.turns + (direction * before.direction < 0)
    moved = before.place + max(settings.target_step, FIRST_STEP / (1 + turns)) * off
    place = max(float(bounds.lowest), min(moved, float(bounds.highest)))
    level = bounds.nearest(math.floor(place + 0.5))
    why = _why_moved(attempt, settings) if level != state.level else ""
    return Difficulty(level, Place(place, direction or before.direction, turns), why)


def _share_reached(attempt: ScoredAttempt, settings: TargetSettings) -> float:
    if settings.target_of == "attempts":
        return float(attempt.outcome == "success")
    return attempt.reached / max(1, attempt.prompts)


def _why_moved(attempt: ScoredAttempt, settings: TargetSettings) -> str:
    target = f"the target is {settings.target_share:g} %"
    if settings.target_of == "attempts":
        return (
            f"Goal {'reached' if attempt.outcome == 'success' else 'missed'}; {target} of attempts."
        )
    return f"{attempt.reached} of {attempt.prompts} prompts reached the goal; {target}."


class PercentileSettings(Settings, frozen=True, kw_only=True):
    """Settings of ``percentile``."""

    percentile_rank: Annotated[
        int,
        setting(
            "Goal is the k-th best",
            help="An attempt succeeds in k of m + 1 cases: 21 of the last 29 makes 70 %.",
            ge=1,
            le=MOST_RESULTS,
        ),
    ] = 21
    percentile_results: Annotated[
        int,
        setting(
            "of the last m results",
            help="Few follow a person fast, but the goal jumps; many keep it stiller.",
            ge=1,
            le=MOST_RESULTS,
        ),
    ] = 29

    def problems(self) -> dict[str, str]:
        """Return an error if there are fewer results than the rank."""
        rank, results = self.percentile_rank, self.percentile_results
        if rank <= results:
            return {}
        text = "The goal cannot be number {rank} of {results} results."
        return {"percentile_rank": Sentence(text, rank=rank, results=results)}


def rank_among(results: int, settings: PercentileSettings) -> int:
    """Return the rank of the goal among so many results: k of m, and with fewer the rank nearest to
    k / (m + 1).
    """
    if results >= settings.percentile_results:
        return settings.percentile_rank
    return max(1, min(results, math.floor(share_of_rank(settings) * (results + 1) + 0.5)))


def percentile_goal(
    results: Sequence[float | None],
    better: Literal["lower", "higher"],
    settings: PercentileSettings,
) -> Goal | None:
    """Return the k-th best of a person's last m results at a level; None (the task's own goal)
    before there is one.

    A percentile schedule (Galbicka 1994; with daily steps: Adams et al. 2013). Whatever the
    distribution of the results, if they come in no particular order and without ties, the next one
    is better than the k-th best of the last m with a probability of exactly k / (m + 1), since it
    is equally likely to take each of the m + 1 ranks.

    An attempt without a result ranks last. If the goal would be such a one, it is the worst result
    instead, which is easier to reach than it should be rather than harder.
    """
    last = results[-settings.percentile_results :]
    ranked = sorted((result for result in last if result is not None), reverse=better == "higher")
    if not ranked:
        return None
    rank = min(rank_among(len(last), settings), len(ranked))
    if len(last) == 1:
        return Goal(ranked[0], "The goal is the last result at this level.")
    return Goal(
        ranked[rank - 1],
        f"The goal is number {rank} of the last {len(last)} results at this level.",
    )


def share_of_rank(settings: PercentileSettings) -> float:
    """Return the share of attempts that are better than the k-th best of the last m."""
    return settings.percentile_rank / (settings.percentile_results + 1)


INCLUDED: Mapping[str, DifficultyPolicy] = {
    "fixed": DifficultyPolicy(
        "Level and goal stay as you set them.", title="Stays as it is", aim=no_share
    ),
    BY_OUTCOME: DifficultyPolicy(
        "Harder when it goes well, easier when it does not.",
        OneUpOneDownSettings,
        step_by_outcome,
        title="Step by step",
        aim=balance,
    ),
    "percentile": DifficultyPolicy(
        "The level stays; the goal follows the results.",
        PercentileSettings,
        goal=percentile_goal,
        title="A goal of their own",
        aim=share_of_rank,
    ),
    "sequence": DifficultyPolicy(
        "You list the level of each attempt.",
        SequenceSettings,
        step_in_list,
        start=start_of_list,
        title="A list of levels",
        aim=no_share,
    ),
    "target": DifficultyPolicy(
        "Aims at 7 of 10 prompts, or at the share you set.",
        TargetSettings,
        step_to_target,
        title="A share of successes",
        aim=target,
    ),
}
"""Included policies by name: a value of the setting ``difficulty_policy``."""

"""The goal moves, not the level: it is the k-th best of a person's last m results at that level.

A percentile schedule (Galbicka 1994; with daily steps: Adams et al. 2013). Whatever the
distribution of the results, if they come in no particular order and without ties, the next one is
better than the k-th best of the last m with a probability of exactly k / (m + 1), since it is
equally likely to take each of the m + 1 ranks.
"""

import math
from collections.abc import Sequence
from typing import Annotated, Literal

from sar_tui.rules.declaration import Settings, meta
from sar_tui.rules.difficulty.policy import MOST_RESULTS, DifficultyPolicy, Goal


class PercentileSettings(Settings, frozen=True, kw_only=True):
    """Settings of the difficulty policy ``percentile``."""

    percentile_rank: Annotated[
        int,
        meta(
            "Goal is the k-th best",
            help="For percentile: k. An attempt succeeds in k of m + 1 cases: 21 of the last 29 "
            "makes 70 %.",
            ge=1,
            le=MOST_RESULTS,
            group="Difficulty",
        ),
    ] = 21
    percentile_results: Annotated[
        int,
        meta(
            "of the last m results",
            help="For percentile: m. Few follow a person fast, but the goal jumps; many keep it "
            "stiller.",
            ge=1,
            le=MOST_RESULTS,
            group="Difficulty",
        ),
    ] = 29

    def problems(self) -> dict[str, str]:
        """Return an error if there are fewer results than the rank."""
        rank, results = self.percentile_rank, self.percentile_results
        if rank <= results:
            return {}
        return {"percentile_rank": f"The goal cannot be number {rank} of {results} results."}


def rank_among(results: int, settings: PercentileSettings) -> int:
    """Return the rank of the goal among so many results: k of m, and with fewer the rank nearest to
    k / (m + 1).
    """
    if results >= settings.percentile_results:
        return settings.percentile_rank
    share = settings.percentile_rank / (settings.percentile_results + 1)
    return max(1, min(results, math.floor(share * (results + 1) + 0.5)))


def goal(
    results: Sequence[float | None],
    better: Literal["lower", "higher"],
    settings: PercentileSettings,
) -> Goal | None:
    """Return the goal made from the last results at a level; None (the task's own) before there is
    one.

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


POLICY = DifficultyPolicy(
    "The level stays, and the goal follows the person: the k-th best of the last m results at "
    "that level.",
    PercentileSettings,
    goal=goal,
)

"""Task-oriented training (thesis 4.2.1, 4.4.1): Figures 4.4, 4.9 and 4.10, the level over twenty
attempts.
"""

from collections.abc import Sequence
from itertools import pairwise
from statistics import fmean

from sar_tui.validation import charts
from sar_tui.validation.charts import draw_levels
from sar_tui.validation.report import Claim, Column, Conditions, Report, Row
from sar_tui.validation.simulated_sessions import Simulated, session_runner

LAST = 10
"""Attempts at the end of a session over which levels of users are compared: they have settled by
then.
"""


def average(conditions: Conditions) -> Report:
    """Return Figure 4.4: one row per attempt of an average user."""
    return _of_user(conditions, "figure-4.4", "average")


def poor(conditions: Conditions) -> Report:
    """Return Figure 4.9: one row per attempt of a poor user."""
    return _of_user(conditions, "figure-4.9", "poor")


def competent(conditions: Conditions) -> Report:
    """Return Figure 4.10: one row per attempt of a competent user."""
    return _of_user(conditions, "figure-4.10", "competent")


def _of_user(conditions: Conditions, name: str, user: str) -> Report:
    rows: list[Row] = []
    with session_runner(conditions.catalogue, conditions.known) as runner:
        for number, seed in enumerate(conditions.seeds):
            conditions.progress(name, number, len(conditions.seeds))
            rows += level_rows(runner.run(user, seed), user, seed)
    first = [row for row in rows if row["seed"] == conditions.seeds[0]]
    seen = [_summed_up(rows, seed) for seed in conditions.seeds]
    title = f"{user.capitalize()} user, seed {conditions.seeds[0]}"
    claims = [follows_results(rows)]
    return Report(
        rows, [_COLUMNS], claims, [draw_levels(first, title)], seen, charts.adaptation(first)
    )


def level_rows(done: Simulated, user: str, seed: int) -> list[Row]:
    """Return one row for each attempt of a session."""
    return [
        {
            "user": user,
            "seed": seed,
            "attempt": attempt["attempt"],
            "level": attempt["level"],
            "reaction_time_ms": attempt["metric"],
            "goal_ms": attempt["goal"],
            "accuracy": attempt["accuracy"],
            "outcome": attempt["outcome"],
            "lowest_level": done.task.parameters.min_level,
            "highest_level": min(done.task.parameters.max_level, done.task.levels),
        }
        for attempt in done.attempts
    ]


def follows_results(rows: Sequence[Row]) -> Claim:
    """Return the claim that the level rises after each success and falls after each failure, within
    its bounds.
    """
    wrong = [
        f"{before['user']}, seed {before['seed']}: level {before['level']} → {after['level']} "
        f"after a {before['outcome']} in attempt {before['attempt']}"
        for before, after in pairwise(rows)
        if (before["user"], before["seed"]) == (after["user"], after["seed"])
        and after["level"] != _expected(before)
    ]
    sentence = "The level rises after each attempt under the goal, and falls after each other one."
    return Claim(sentence, _listed(wrong))


def ranks_users(rows: Sequence[Row]) -> Claim:
    """Return the claim that better users train at higher levels, whatever the seed."""
    wrong = []
    for seed in dict.fromkeys(row["seed"] for row in rows):
        means = {
            user: fmean(
                row["level"]
                for row in rows
                if (row["user"], row["seed"]) == (user, seed) and _is_late(row)
            )
            for user in ("poor", "average", "competent")
        }
        if not means["poor"] < means["average"] < means["competent"]:
            wrong.append(
                f"seed {seed}: {', '.join(f'{user} {mean:.1f}' for user, mean in means.items())}"
            )
    sentence = f"Over the last {LAST} attempts, better users train at higher levels, in every seed."
    return Claim(sentence, _listed(wrong))


def _is_late(row: Row) -> bool:
    return bool(row["attempt"] > 20 - LAST)


def _expected(row: Row) -> int:
    step = 1 if row["outcome"] == "success" else -1
    return int(max(row["lowest_level"], min(row["level"] + step, row["highest_level"])))


def _listed(wrong: Sequence[str]) -> str:
    """Return the first exceptions, and the number of others."""
    more = f"; and {len(wrong) - 3} more" if len(wrong) > 3 else ""
    return "; ".join(wrong[:3]) + more


def _summed_up(rows: Sequence[Row], seed: int) -> Row:
    own = [row for row in rows if row["seed"] == seed]
    reached = [row for row in own if row["outcome"] == "success"]
    levels = [row["level"] for row in own]
    return {
        "seed": seed,
        "reached": len(reached),
        "lowest": min(levels),
        "highest": max(levels),
        "last": levels[-1],
    }


_COLUMNS = [
    Column("seed", lambda row: str(row["seed"])),
    Column("goals reached", lambda row: str(row["reached"])),
    Column("lowest level", lambda row: str(row["lowest"])),
    Column("highest level", lambda row: str(row["highest"])),
    Column("last level", lambda row: str(row["last"])),
]

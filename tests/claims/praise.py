"""Praise by chance, and praise of a true change: of drawn attempts, and in whole sessions."""

import random
from collections.abc import Sequence
from statistics import fmean

from sar_tui.progress.change import mdc95
from sar_tui.rules.real_change import LEAST_ATTEMPTS, LEAST_TRIALS, Sample, judge, spread_of
from sar_tui.validation.report import Claim, Conditions, Report, Row
from tests.claims.noise_worlds import WORLDS, Attempts, sem
from tests.claims.praised_sessions import TASKS, session_row

EARLIER: tuple[int, ...] = (2, 3, 5, 10)
QUICK_EARLIER = EARLIER[:3]
TRIALS = (1, 3, 5)
SEVERAL, TRIALS_OF_SEVERAL = 3, 4
"""Measures that are judged together, and the trials of their attempts."""
PAIRS, QUICK_PAIRS = 2000, 600
QUICK_TASKS: tuple[str, ...] = ()
"""Whole sessions take too long for a quick run."""
MOST_BY_CHANCE, LEAST_FOUND = 0.10, 0.80
MDCS = 2.0
"""The true change that must be found, in MDC95."""


def run(conditions: Conditions) -> Report:
    """Return one row for each world, number of trials and of earlier attempts, and one for each
    task's sessions.
    """
    rows: list[Row] = []
    pairs, numbers, tasks = PAIRS, EARLIER, list(TASKS)
    if conditions.is_quick:
        pairs, numbers, tasks = QUICK_PAIRS, QUICK_EARLIER, list(QUICK_TASKS)
    steps = len(WORLDS) + len(tasks)
    for number, world in enumerate(WORLDS):
        conditions.progress(f"praise: {world}", number, steps)
        cases = [(trials, 1) for trials in TRIALS] + [(TRIALS_OF_SEVERAL, SEVERAL)]
        rows += [
            _row(world, trials, earlier, measures, pairs)
            for trials, measures in cases
            for earlier in numbers
        ]
    for number, task in enumerate(tasks, len(WORLDS)):
        conditions.progress(f"praise: {task}", number, steps)
        rows.append(session_row(conditions, task))
    return Report(rows, (), _claims(rows))


def _row(world: str, trials: int, earlier: int, measures: int, pairs: int) -> Row:
    rng = random.Random(f"{world} {trials} {earlier} {measures}")
    change = MDCS * mdc95(sem(world, trials))
    drawn = [
        [_samples(WORLDS[world](rng, earlier + 1, trials)) for _ in range(measures)]
        for _ in range(pairs)
    ]
    is_known = earlier >= LEAST_ATTEMPTS and earlier * trials >= LEAST_TRIALS
    return {
        "world": world,
        "measures": measures,
        "trials": trials,
        "earlier": earlier,
        "pairs": pairs,
        "better_by_chance": fmean(_is_praised(each) for each in drawn),
        "changes": pairs if is_known else 0,
        "better_if_changed": fmean(_is_praised(each, change) for each in drawn)
        if is_known
        else None,
    }


def _samples(attempts: Attempts) -> list[Sample]:
    return [Sample(fmean(trials), len(trials), spread_of(trials)) for trials in attempts]


def _is_praised(measures: Sequence[Sequence[Sample]], change: float = 0.0) -> bool:
    """Return True if the last attempt is called better in one of the measures, the first of which
    has changed.
    """
    shifts = [change, *[0.0] * (len(measures) - 1)]
    return any(
        _verdict(each, shift, len(measures)) == "better"
        for each, shift in zip(measures, shifts, strict=True)
    )


def _verdict(attempts: Sequence[Sample], change: float, measures: int) -> str:
    *earlier, now = attempts
    found = judge(
        Sample(now.mean + change, now.n, now.sd), earlier[-1], earlier, "higher", measures=measures
    )
    return found.verdict if found else ""


def _claims(rows: Sequence[Row]) -> list[Claim]:
    too_many = [row for row in rows if row["better_by_chance"] > MOST_BY_CHANCE]
    judged = [
        row
        for row in rows
        if row["better_if_changed"] is not None and (row["measures"] == 1 or not row["earlier"])
    ]
    too_few = [row for row in judged if row["better_if_changed"] < LEAST_FOUND]
    early = [row for row in rows if row["earlier"] is not None and row["better_if_changed"] is None]
    return [
        Claim(
            f'With nothing trained, "better" is said of at most {MOST_BY_CHANCE:.0%} of attempts.',
            ", ".join(f"{_name(row)}: {row['better_by_chance']:.1%}" for row in too_many),
        ),
        Claim(
            f"After a true change of {MDCS:g} MDC95 of a measure it is said of at least "
            f"{LEAST_FOUND:.0%}.",
            ", ".join(f"{_name(row)}: {row['better_if_changed']:.1%}" for row in too_few),
        ),
        Claim(
            f"It is never said before {LEAST_ATTEMPTS} earlier attempts with {LEAST_TRIALS} "
            "trials in all.",
            ", ".join(_name(row) for row in early if row["better_by_chance"]),
        ),
    ]


def _name(row: Row) -> str:
    if row["earlier"] is None:
        return f"sessions of {row['world']}"
    return f"{row['world']}, {row['earlier']} attempts of {row['trials']}"

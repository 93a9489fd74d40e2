"""Corrections by chance, and of a true decline: of drawn attempts, and in whole sessions."""

import random
import tempfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from statistics import fmean

import msgspec

from sar_tui.loop.task import Task
from sar_tui.rules.decline import LEAST_BASELINE, RECENT, decline
from sar_tui.simulation.participant_model import PEOPLE, Person
from sar_tui.validation.report import Claim, Conditions, Report, Row
from tests.claims.noise_worlds import WORLDS, sem
from tests.claims.praised_sessions import told_in_session

ATTEMPTS = 20
"""Attempts of a session without change."""
SESSIONS, QUICK_SESSIONS = 600, 150
TRIALS = (1, 5)
MEASURES = (1, 3, 4)
"""Numbers of measures that are judged together; a reach has three, and a fourth with a sensor on
the trunk.
"""
EARLIER = (LEAST_BASELINE, 15)
"""Attempts before the first that is worse."""
DECLINES, QUICK_DECLINES = 2000, 600
SDS = 3.0
"""Decline of one measure that must be found, in SD of the person's attempts; it lasts."""
WITHIN = 3
"""Attempts within which it must be found, the first that is worse included."""
MOST_BY_CHANCE, LEAST_FOUND = 0.05, 0.90
CLAIMED_MEASURES, CLAIMED_EARLIER = 3, 15
NOT_CLAIMED = ("drift", "spoilt")
"""Worlds in which an attempt may differ by more than chance: slowly, or as it was spoilt."""
TASK, REACHES, MEASURED = "reaching", 3, 3
"""A task that measures movements, the reaches of an attempt, and the measures without a sensor on
the trunk.
"""
SEEDS, QUICK_SEEDS = 4, 0
"""Whole sessions of each simulated user; they take too long for a quick run."""


def run(conditions: Conditions) -> Report:
    """Return rows for each world, number of measures and of trials, and one for a task's
    sessions.
    """
    rows: list[Row] = []
    steps = len(WORLDS) + 1
    for number, world in enumerate(WORLDS):
        conditions.progress(f"corrections: {world}", number, steps)
        for measures in MEASURES:
            for trials in TRIALS:
                rows.append(_without_change(world, measures, trials, conditions.is_quick))
                rows += [
                    _with_decline(world, measures, trials, earlier, conditions.is_quick)
                    for earlier in EARLIER
                ]
    if seeds := QUICK_SEEDS if conditions.is_quick else SEEDS:
        conditions.progress(f"corrections: {TASK}", len(WORLDS), steps)
        rows.append(_sessions(conditions, seeds))
    return Report(rows, (), _claims(rows))


def _without_change(world: str, measures: int, trials: int, is_quick: bool) -> Row:
    """Return how often any measure is corrected in sessions in which none changes."""
    rng = random.Random(f"{world} {measures} {trials}")
    sessions = QUICK_SESSIONS if is_quick else SESSIONS
    corrected = 0
    for _ in range(sessions):
        drawn = [_means(world, rng, ATTEMPTS, trials) for _ in range(measures)]
        corrected += sum(
            _is_corrected(drawn, attempt, measures) for attempt in range(1, ATTEMPTS + 1)
        )
    return _row(world, measures, trials, attempts=sessions * ATTEMPTS, corrected=corrected)


def _with_decline(world: str, measures: int, trials: int, earlier: int, is_quick: bool) -> Row:
    """Return how often a lasting decline of one measure is named within one, two and three
    attempts.
    """
    rng = random.Random(f"{world} {measures} {trials} {earlier}")
    count = QUICK_DECLINES if is_quick else DECLINES
    by = SDS * sem(world, trials)
    after = [0] * WITHIN
    for _ in range(count):
        means = _means(world, rng, earlier + WITHIN, trials)
        worse = [mean - by * (number >= earlier) for number, mean in enumerate(means)]
        named = [_is_corrected([worse], earlier + more, measures) for more in range(1, WITHIN + 1)]
        for number in range(WITHIN):
            after[number] += any(named[: number + 1])
    found = {f"found_within_{number + 1}": each / count for number, each in enumerate(after)}
    return _row(world, measures, trials, earlier=earlier, declines=count, found=found)


def _means(world: str, rng: random.Random, count: int, trials: int) -> list[float]:
    return [fmean(attempt) for attempt in WORLDS[world](rng, count, trials)]


def _is_corrected(drawn: Sequence[Sequence[float]], attempt: int, measures: int) -> bool:
    """Return True if any of the measures is corrected at an attempt, counted from 1."""
    return any(decline(means[:attempt], "higher", measures=measures) for means in drawn)


def _row(
    world: str,
    measures: int,
    trials: int,
    *,
    attempts: int = 0,
    corrected: int = 0,
    earlier: int | None = None,
    declines: int = 0,
    found: Row | None = None,
) -> Row:
    """Return a row; what does not apply is None."""
    judged = attempts * (ATTEMPTS - LEAST_BASELINE - RECENT + 1) / ATTEMPTS
    return {
        "world": world,
        "measures": measures,
        "trials": trials,
        "earlier": earlier,
        "attempts": attempts,
        "corrected_by_chance": corrected / attempts if attempts else None,
        "corrected_with_baseline": corrected / judged if attempts else None,
        "declines": declines,
        **{f"found_within_{number}": None for number in range(1, WITHIN + 1)},
        **(found or {}),
    }


def _sessions(conditions: Conditions, seeds: int) -> Row:
    """Return how often people without practice or fatigue hear a correction in whole sessions of a
    task.
    """
    kind = conditions.catalogue.task(TASK)
    settings = {
        "attempts": ATTEMPTS,
        "reaches_per_attempt": REACHES,
        "feedback_form": "qualitative",
    }
    texts: list[str] = []
    with tempfile.TemporaryDirectory(prefix="sar-tui-validate-") as folder:
        play = partial(
            told_in_session, conditions, Path(folder), kind, settings | {"feedback_on": "both"}
        )
        for user in PEOPLE.values():
            steady = Person(**msgspec.structs.asdict(user) | {"practice": 0.0, "fatigue": 0.0})
            texts += [told.text for seed in range(1, seeds + 1) for told in play(steady, seed)]
    corrected = sum(names_a_correction(text, kind) for text in texts)
    row = _row(TASK, MEASURED, REACHES, attempts=len(texts), corrected=corrected)
    return row | {"corrected_with_baseline": None}  # not all attempts of a session are comparable


def names_a_correction(text: str, kind: type[Task]) -> bool:
    """Return True if a text of feedback in English asks for another way to move."""
    return any(quality.aim in text for quality in kind.qualities)


def _claims(rows: Sequence[Row]) -> list[Claim]:
    too_many = [
        row for row in rows if row["attempts"] and row["corrected_by_chance"] > MOST_BY_CHANCE
    ]
    last = f"found_within_{WITHIN}"
    claimed = [
        row
        for row in rows
        if row["measures"] <= CLAIMED_MEASURES
        and row["earlier"] == CLAIMED_EARLIER
        and row["world"] not in NOT_CLAIMED
    ]
    too_few = [row for row in claimed if row[last] < LEAST_FOUND]
    return [
        Claim(
            f"With nothing changed, at most {MOST_BY_CHANCE:.0%} of the attempts of a session "
            "hear any correction.",
            ", ".join(f"{_name(row)}: {row['corrected_by_chance']:.1%}" for row in too_many),
        ),
        Claim(
            f"A quality that gets worse by {SDS:g} SD and stays so is named within {WITHIN} "
            "attempts in at least "
            f"{LEAST_FOUND:.0%}, of up to {CLAIMED_MEASURES} measures, after {CLAIMED_EARLIER} "
            "attempts.",
            ", ".join(f"{_name(row)}: {row[last]:.1%}" for row in too_few),
        ),
        Claim(
            f"No correction is given before {LEAST_BASELINE} attempts and the {RECENT} that are "
            "judged.",
            _too_early(),
        ),
    ]


def _too_early() -> str:
    """Return the first number of attempts after which the worst decline is named, if it is too
    small.
    """
    worst = [[1.0] * earlier + [-1e6] * RECENT for earlier in range(LEAST_BASELINE)]
    return ", ".join(f"{len(means)} attempts" for means in worst if decline(means, "higher"))


def _name(row: Row) -> str:
    return f"{row['world']}, {row['measures']} measures, {row['trials']} trials"

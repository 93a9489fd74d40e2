"""Sessions with made-up results, without a database."""

import random
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime, timedelta
from typing import Any

from sar_tui.model.trial_types import Metric
from sar_tui.progress.lines import SessionResults
from sar_tui.progress.task_level import AttemptResult

REACTION_TIME = Metric(
    "reaction_time", unit="ms", better="lower", improved="faster", worsened="slower"
)
START = datetime(2026, 2, 27, 10, tzinfo=UTC)


def session(
    number: int, results: Sequence[AttemptResult], parameters: Mapping[str, Any] = {}, *,
    on_day: int | None = None, **more: Any,
) -> SessionResults:  # fmt: skip
    """Return session ``number``, played ``on_day`` days after the first day; by default on a day of
    its own.
    """
    began = START + timedelta(days=number if on_day is None else on_day, minutes=number)
    times = [result.metric for result in results if result.metric is not None]
    facts: dict[str, Any] = {
        "session": f"session{number:03}", "began": began, "task": "keyboard",
        "title": "Keyboard reaction", "task_version": "2", "seat": "A", "mode": "live",
        "status": "completed", "metric": REACTION_TIME, "parameters": {"attempts": 20, **parameters},
        "results": results, "reached": sum(time < 1000 for time in times),
        "trials": 20 * len(results), "right": sum(result.correct for result in results),
        "seconds": 30.0 * len(results), "qualities": {},
    }  # fmt: skip
    return SessionResults(**(facts | more))


def adapted(seed: int, *, base: float = 450.0, attempts: int = 20) -> list[AttemptResult]:
    """Return attempts of a person whose times grow by 165 ms a level, one level up or down after
    each.
    """
    rng, level, made = random.Random(seed), 1, []
    for _ in range(attempts):
        mean = base + 165.0 * level + rng.gauss(0, 35)
        made.append(AttemptResult(level, mean, 19))
        level = max(1, level + (1 if mean < 1000 else -1))
    return made


def at_one_level(seed: int, mean: float, attempts: int = 12) -> list[AttemptResult]:
    """Return attempts at level 3."""
    rng = random.Random(seed)
    return [AttemptResult(3, mean + rng.gauss(0, 30), 20) for _ in range(attempts)]

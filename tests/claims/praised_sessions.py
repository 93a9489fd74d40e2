"""Praise in whole sessions of simulated participants: of those who never change, and of those who
do.
"""

import re
import tempfile
from collections.abc import Callable, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from statistics import fmean, variance
from typing import Any, NamedTuple

import msgspec

from sar_tui.loop.task import Task
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import Performance
from sar_tui.progress.change import mdc95
from sar_tui.rules.real_change import LEAST_ATTEMPTS
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE, Person
from sar_tui.store import sessions
from sar_tui.store.database import connect
from sar_tui.validation.report import Conditions, Row

ATTEMPTS = 8
"""The last one is that of the change."""
SEEDS, QUICK_SEEDS = 12, 4
MDCS = 2.0
ROUNDS = 1
MOST_GAIN = 0.7
"""Nobody saves more of a time."""
TASKS: dict[str, dict[str, Any]] = {
    "keyboard": {"prompts_per_attempt": 10},
    "reaching": {"reaches_per_attempt": 5, "feedback_on": "both"},
}
"""The tasks, with their settings."""


class Changing(Person, frozen=True):
    """A person who never changes, but for a gain at one attempt: ``gain`` is the share of all times
    that it saves.
    """

    at_attempt: int = 0
    gain: float = 0.0

    def perform(self, choices: int, attempt: int, streams: RandomStreams) -> Performance:
        usual = super().perform(choices, attempt, streams)
        left = 1 - self.gain if attempt == self.at_attempt else 1.0
        return Performance(
            usual.reaction_ms * left, usual.slips, lambda: usual.pace * left, usual.unsteadiness
        )


class Told(NamedTuple):
    """An attempt: its result, and the text of the feedback on it."""

    result: float | None
    text: str


def session_row(conditions: Conditions, task: str) -> Row:
    """Return the figures of a task's sessions, by the three simulated users."""
    kind = conditions.catalogue.task(task)
    seeds = range(1, (QUICK_SEEDS if conditions.is_quick else SEEDS) + 1)
    usual: list[str] = []
    changed: list[str] = []
    with tempfile.TemporaryDirectory(prefix="sar-tui-validate-") as folder:
        settings = {"attempts": ATTEMPTS, "feedback_form": "both", **TASKS[task]}
        play = partial(told_in_session, conditions, Path(folder), kind, settings)
        for user in PEOPLE.values():
            person = Changing(**msgspec.structs.asdict(user) | {"practice": 0.0, "fatigue": 0.0})
            played = [play(person, seed) for seed in seeds]
            usual += [each.text for told in played for each in told[LEAST_ATTEMPTS:]]
            changed += [each.text for each in _changed(play, person, seeds, played)]
    return {
        "world": task,
        "measures": 1 + len([quality for quality in kind.qualities if quality.praised]),
        "trials": next(iter(TASKS[task].values())),
        "earlier": None,
        "pairs": len(usual),
        "better_by_chance": fmean(says_better(text, kind) for text in usual),
        "changes": len(changed),
        "better_if_changed": fmean(says_better(text, kind) for text in changed),
    }


def _changed(
    play: Callable[[Person, int], list[Told]],
    person: Changing,
    seeds: Sequence[int],
    usual: Sequence[Sequence[Told]],
) -> list[Told]:
    """Return the last attempts of sessions in which the result is better there by two MDC95, on
    average.

    Not all of a reach grows with its pace, so that the gain is corrected after a round of the same
    sessions.
    """
    results = [[each.result for each in told if each.result is not None] for told in usual]
    wanted = MDCS * mdc95(fmean(variance(each) for each in results) ** 0.5)
    gain = wanted / fmean(fmean(each) for each in results)
    for _ in range(ROUNDS):
        tried = _last(play, person, seeds, gain)
        pairs = [(told[-1].result, each.result) for told, each in zip(usual, tried, strict=True)]
        reached = fmean(
            before - after for before, after in pairs if before is not None and after is not None
        )
        gain = min(gain * wanted / reached, MOST_GAIN)
    return _last(play, person, seeds, gain)


def _last(
    play: Callable[[Person, int], list[Told]], person: Changing, seeds: Sequence[int], gain: float
) -> list[Told]:
    changing = msgspec.structs.replace(person, at_attempt=ATTEMPTS, gain=gain)
    return [play(changing, seed)[-1] for seed in seeds]


def says_better(text: str, kind: type[Task]) -> bool:
    """Return True if a text of feedback in English calls something better than before."""
    words = {kind.metric.improved, *(quality.improved for quality in kind.qualities)}
    return any(re.search(rf"\b{re.escape(word)} than\b", text) for word in words)


def told_in_session(
    conditions: Conditions,
    folder: Path,
    kind: type[Task],
    settings: dict[str, Any],
    person: Person,
    seed: int,
) -> list[Told]:
    """Run a session at one level, and return its attempts."""
    asked = {"difficulty_policy": "fixed", **settings}
    plan = make_plan(conditions.catalogue, kind, ["SIM"], asked, seed=seed, mode="simulated")
    name = simulate(plan, person, folder, conditions.catalogue)
    with closing(connect(folder)) as database:
        actions = sessions.rows(database, "actions", name)
        texts = {row["final"]["attempt"]: row["final"]["text"] for row in actions if _is_said(row)}
        attempts = sessions.rows(database, "attempts", name)
    return [Told(row["metric"], texts.get(row["attempt"], "")) for row in attempts]


def _is_said(row: Row) -> bool:
    return row["kind"] == "feedback" and bool(row["final"])

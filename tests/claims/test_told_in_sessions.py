"""People whose performance does not change are seldom told otherwise in whole sessions, and those
who get better are told.
"""

import re
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from statistics import fmean, variance
from typing import Any, NamedTuple

import msgspec
import pytest

from sar_tui.loop.task import Task
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import Performance
from sar_tui.plugins import Catalogue
from sar_tui.progress.change import mdc95
from sar_tui.rules.real_change import LEAST_ATTEMPTS
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE, Person
from sar_tui.store import sessions
from sar_tui.store.database import connect
from tests.examples import first, first_rows

MDCS = 2.0
"""The true change that must be found, in MDC95."""
ATTEMPTS = 8
"""The last one is that of the change."""
MOST_GAIN = 0.7
"""Nobody saves more of a time."""
TASKS: dict[str, dict[str, Any]] = {
    "keyboard": {"prompts_per_attempt": 10},
    "reaching": {"reaches_per_attempt": 5, "feedback_on": "both"},
}


class Steady(Person, frozen=True):
    """A person who never changes, but for a gain at one attempt: the share of all times that it
    saves.
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
    """The result of an attempt, and the text of the feedback on it."""

    result: float | None
    text: str


Play = Callable[..., list[Told]]


@pytest.fixture
def play(data: Path, catalogue: Catalogue, fewer_blocks: None) -> Play:
    """Run a session at one level, and return its attempts."""

    def run(task: str, person: Person, seed: int, **settings: Any) -> list[Told]:
        settings["difficulty_policy"] = "fixed"
        plan = make_plan(catalogue, task, ["SIM"], settings, seed=seed, mode="simulated")
        session = simulate(plan, person, data, catalogue)
        with closing(connect(data)) as database:
            said = [
                row["final"]
                for row in sessions.rows(database, "actions", session)
                if row["kind"] == "feedback" and row["final"]
            ]
            attempts = sessions.rows(database, "attempts", session)
        texts = {each["attempt"]: each["text"] for each in said}
        return [Told(row["metric"], texts.get(row["attempt"], "")) for row in attempts]

    return run


def steady(user: str) -> Steady:
    return Steady(**msgspec.structs.asdict(PEOPLE[user]) | {"practice": 0.0, "fatigue": 0.0})


def says_better(text: str, kind: type[Task]) -> bool:
    """Return True if a text of feedback in English calls something better than before."""
    words = {kind.metric.improved, *(quality.improved for quality in kind.qualities)}
    return any(re.search(rf"\b{re.escape(word)} than\b", text) for word in words)


@pytest.mark.slow
@pytest.mark.parametrize(("task", "seeds"), first_rows(1, [("keyboard", 2), ("reaching", 4)]))
def test_an_attempt_is_called_better_mostly_after_a_true_change_and_seldom_without(
    play: Play, catalogue: Catalogue, task: str, seeds: int
) -> None:
    def played(person: Steady) -> list[list[Told]]:
        return [
            play(task, person, seed, attempts=ATTEMPTS, feedback_form="both", **TASKS[task])
            for seed in range(1, seeds + 1)
        ]

    kind = catalogue.task(task)
    usual_texts: list[str] = []
    changed_texts: list[str] = []
    for user in PEOPLE:
        usual = played(steady(user))
        usual_texts += [each.text for told in usual for each in told[LEAST_ATTEMPTS:]]
        changed_texts += [told[-1].text for told in changed_by_two_mdc(played, user, usual)]
    assert fmean(says_better(text, kind) for text in usual_texts) <= 0.1
    assert fmean(says_better(text, kind) for text in changed_texts) >= 0.8


def changed_by_two_mdc(
    played: Callable[[Steady], list[list[Told]]], user: str, usual: list[list[Told]]
) -> list[list[Told]]:
    """Return sessions whose last result is better by two MDC95 than usual, on average.

    Not all of a reach grows with its pace: the gain is corrected after one round of the same
    sessions.
    """

    def with_gain(gain: float) -> list[list[Told]]:
        return played(msgspec.structs.replace(steady(user), at_attempt=ATTEMPTS, gain=gain))

    results = [[each.result for each in told if each.result is not None] for told in usual]
    wanted = MDCS * mdc95(fmean(variance(each) for each in results) ** 0.5)
    gain = wanted / fmean(fmean(each) for each in results)
    lasts = [
        (before[-1].result, after[-1].result)
        for before, after in zip(usual, with_gain(gain), strict=True)
    ]
    reached = fmean(
        before - after for before, after in lasts if before is not None and after is not None
    )
    return with_gain(min(gain * wanted / reached, MOST_GAIN))


@pytest.mark.slow
@pytest.mark.parametrize("user", first(1, PEOPLE))
def test_the_movements_of_steady_people_are_seldom_praised_or_corrected(
    play: Play, catalogue: Catalogue, user: str
) -> None:
    kind = catalogue.task("reaching")
    settings = {"attempts": 20, "reaches_per_attempt": 3, "feedback_on": "both"}
    told = play("reaching", steady(user), 1, feedback_form="qualitative", **settings)
    assert len(told) == 20
    assert fmean(says_better(each.text, kind) for each in told) <= 0.1
    aims = [quality.aim for quality in kind.qualities]
    assert fmean(any(aim in each.text for aim in aims) for each in told) <= 0.05

"""Attempts that are played in advance by a simulated person like the participant."""

import itertools
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.loop.task import Task
from sar_tui.model.theme import Theme
from sar_tui.plugins import Catalogue
from sar_tui.progress.lines import SessionResults
from sar_tui.rules.parameters import build
from sar_tui.runs.plan import make_plan
from sar_tui.runs.preview import (
    ATTEMPTS,
    Preview,
    StandIn,
    finish,
    make_stand_in,
    play_ahead,
)
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store.database import connect
from sar_tui.store.results import newest_of


@pytest.fixture
def theme(catalogue: Catalogue) -> Theme:
    return catalogue.theme("calm", "en")


def played(
    kind: type[Task],
    theme: Theme,
    sessions: list[SessionResults] | None = None,
    stand_in: StandIn | None = None,
    **settings: Any,
) -> Preview:
    parameters = build(kind.Parameters, settings)
    return finish(play_ahead(kind, parameters, theme, sessions or [], stand_in or StandIn()))


def trained(
    data: Path, catalogue: Catalogue, task: str, who: str, sessions: int = 2, **settings: Any
) -> list[SessionResults]:
    """Return the results of live sessions of a person of some skill."""
    for seed in range(1, sessions + 1):
        plan = make_plan(
            catalogue, task, ["P01"], {"attempts": 8, **settings}, seed=seed, mode="simulated"
        )
        simulate(plan, PEOPLE[who], data, catalogue)
    with closing(connect(data)) as database, database:
        database.execute("UPDATE sessions SET mode='live'")
        return newest_of(database, "P01", task, 16)


@pytest.mark.slow
def test_the_same_settings_are_played_alike_and_twenty_attempts_long(
    keyboard: type[Task], theme: Theme
) -> None:
    preview = played(keyboard, theme, attempts=3, practice_attempts=4, ask_wellbeing=True)
    assert len(preview.attempts) == ATTEMPTS
    assert preview == played(keyboard, theme)


def test_rules_are_played_for_real(keyboard: type[Task], theme: Theme) -> None:
    steps = played(keyboard, theme)
    assert steps.follows == "level"
    for one, other in itertools.pairwise(steps.attempts):
        assert other.level == one.level + (1 if one.reached else -1)
    fixed = played(keyboard, theme, difficulty_policy="fixed", start_level=4)
    assert {each.level for each in fixed.attempts} == {4}
    assert fixed.follows == ""
    own = played(keyboard, theme, difficulty_policy="percentile")
    assert own.follows == "goal"
    assert len({each.goal for each in own.attempts}) > 1
    listed = played(keyboard, theme, difficulty_policy="sequence", level_sequence=(2, 3))
    assert [each.level for each in listed.attempts] == [2] + [3] * (ATTEMPTS - 1)


def test_prompts_that_reached_the_goal_are_counted_for_the_rule_that_aims_at_them(
    keyboard: type[Task], theme: Theme
) -> None:
    target = played(keyboard, theme, difficulty_policy="target", target_share=70)
    assert target.share_of_prompts == pytest.approx(0.7, abs=0.1)
    assert played(keyboard, theme).share_of_prompts is None, "other rules do not look at it"


@pytest.mark.slow
def test_a_stand_in_is_as_fast_as_the_person(
    keyboard: type[Task], theme: Theme, data: Path, catalogue: Catalogue
) -> None:
    assert finish(make_stand_in(keyboard, [], theme)) == StandIn()
    results = trained(data, catalogue, "keyboard", "poor")
    slow = finish(make_stand_in(keyboard, results, theme))
    assert (slow.sessions, slow.is_like) == (2, True)
    true = PEOPLE["poor"]
    assert slow.person.mean_ms(4, 1) == pytest.approx(true.mean_ms(4, 1), rel=0.1)
    as_slow = played(keyboard, theme, results, slow)
    assert as_slow.highest < played(keyboard, theme).highest


@pytest.mark.slow
def test_a_stand_in_does_not_depend_on_the_goal_that_is_set(
    keyboard: type[Task], theme: Theme, data: Path, catalogue: Catalogue
) -> None:
    results = trained(data, catalogue, "keyboard", "average")
    stand_in = finish(make_stand_in(keyboard, results, theme))
    easy = played(keyboard, theme, results, stand_in, threshold=1500.0)
    hard = played(keyboard, theme, results, stand_in, threshold=600.0)
    assert easy.highest > hard.highest


@pytest.mark.slow
def test_results_that_nobody_simulated_can_have_are_said_to_be_so(
    keyboard: type[Task], theme: Theme, data: Path, catalogue: Catalogue
) -> None:
    results = trained(data, catalogue, "keyboard", "average")
    with closing(connect(data)) as database, database:
        database.execute("UPDATE attempts SET metric=90000")
        results = newest_of(database, "P01", "keyboard", 16)
    assert finish(make_stand_in(keyboard, results, theme)) == StandIn(is_like=False)


@pytest.mark.slow
@pytest.mark.parametrize("task", ["reaching", "pairs", "tapping", "nback"])
def test_other_tasks_are_played_too(task: str, catalogue: Catalogue, theme: Theme) -> None:
    preview = played(catalogue.task(task), theme)
    assert len(preview.attempts) == ATTEMPTS
    assert preview.with_goal == ATTEMPTS

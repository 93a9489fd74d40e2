"""A live session starts where the last one showed the person to be, unless the start level is
fixed.
"""

import sqlite3
from pathlib import Path
from typing import Any

import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node
from sar_tui.loop.task import Task
from sar_tui.model.theme import Theme
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import start
from sar_tui.simulation.participant import SimulatedParticipant
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store.database import FILE
from sar_tui.store.programmes import Programme

FEW = {"attempts": 12, "prompts_per_attempt": 6}


@pytest.fixture
def play(data: Path, catalogue: Catalogue) -> Any:
    """Play a live session of P01 to its end, and return the levels of its attempts and its stored
    start level.
    """

    def nodes(task: Task, theme: Theme, seed: int) -> list[Node]:
        return [SimulatedParticipant(PEOPLE["average"], task, seed)]

    def played(
        seed: int = 1, saved: Programme | None = None, **settings: object
    ) -> tuple[list[int], int]:
        plan = make_plan(
            catalogue, "keyboard", ["P01"], {**FEW, **settings}, saved=saved, seed=seed
        )
        clock = VirtualClock()
        run = start(plan, data, catalogue, clock, nodes)
        run.begin()
        while not run.session.ended and clock.step():
            pass
        run.close()
        database = sqlite3.connect(data / FILE)
        levels = database.execute(
            "SELECT level FROM attempts WHERE session=? ORDER BY attempt", (run.id,)
        ).fetchall()
        (stored,) = database.execute(
            "SELECT json_extract(parameters, '$.start_level') FROM sessions WHERE id=?", (run.id,)
        ).fetchone()
        database.close()
        return [level for (level,) in levels], stored

    return played


def test_the_first_session_starts_at_the_start_level(play: Any) -> None:
    levels, stored = play()
    assert (levels[0], stored) == (1, 1)


def test_the_next_session_starts_at_the_hardest_level_whose_goal_is_expected_to_be_reached(
    play: Any,
) -> None:
    first, _ = play()
    levels, stored = play(2)
    assert levels[0] == stored == max(first) - 1


def test_the_next_session_can_start_at_the_last_level(play: Any) -> None:
    first, _ = play(1, attempts=3)
    levels, _ = play(2, start_from="last level")
    assert levels[0] == first[-1] == 3


def test_without_an_estimate_the_last_level_is_used(play: Any) -> None:
    first, _ = play(1, attempts=2)  # both were easy: nothing is known but that
    levels, _ = play(2)
    assert levels[0] == first[-1]


def test_a_fixed_start_level_stays(play: Any) -> None:
    play()
    assert play(2, start_from="fixed")[0][0] == 1


def test_a_start_level_set_for_this_session_is_fixed(play: Any) -> None:
    play()
    assert play(2, start_level=2)[0][0] == 2
    assert play(3, start_level=2, start_from="estimate")[0][0] > 2


def test_the_start_level_stays_within_the_bounds(play: Any) -> None:
    play()
    assert play(2, max_level=2)[0][0] == 2


@pytest.mark.parametrize("policy", ["fixed", "percentile"])
def test_a_policy_that_leaves_the_level_to_the_therapist_starts_where_they_set_it(
    play: Any, policy: str
) -> None:
    play()
    assert play(2, difficulty_policy=policy)[0][0] == 1


def test_after_a_change_of_the_goal_alone_the_level_follows_from_the_times_and_the_new_goal(
    play: Any,
) -> None:
    play()
    same, _ = play(2)
    harder, _ = play(3, threshold=850.0)
    assert 1 < harder[0] < same[0]


def test_the_start_level_is_used_if_no_result_reaches_the_new_goal(play: Any) -> None:
    play()
    assert play(2, threshold=200.0, start_level=2, start_from="estimate")[0][0] == 2


def test_after_a_change_of_what_is_measured_the_start_level_is_used(play: Any) -> None:
    play()
    assert play(2, choice_set="arrow keys")[0][0] == 1


def test_a_simulated_session_always_starts_at_the_start_level(
    data: Path, catalogue: Catalogue, play: Any
) -> None:
    from sar_tui.runs.simulate import simulate

    play()
    plan = make_plan(catalogue, "keyboard", ["P01"], FEW, seed=4, mode="simulated")
    session = simulate(plan, PEOPLE["average"], data, catalogue)
    with sqlite3.connect(data / FILE) as database:
        found = database.execute(
            "SELECT level FROM attempts WHERE session=? AND attempt=1", (session,)
        ).fetchone()
    assert found == (1,)

"""A live session starts where the last one showed the person to be, unless the start level is
fixed.
"""

from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import start
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import connect
from tests import played

FEW = {"attempts": 12, "prompts_per_attempt": 6}


@pytest.fixture
def play(data: Path, catalogue: Catalogue) -> Any:
    """Play a live session of P01 to its end, and return the levels of its attempts and its stored
    start level.
    """

    def of_levels(seed: int = 1, **settings: object) -> tuple[list[int], int]:
        plan = make_plan(catalogue, "keyboard", ["P01"], {**FEW, **settings}, seed=seed)
        clock = VirtualClock()
        session = played.play(start(plan, data, catalogue, clock, played.somebody), clock)
        with closing(connect(data)) as database:
            rows = sessions.rows(database, "attempts", session)
            stored = sessions.find(database, data, session)["parameters"]["start_level"]
        return [row["level"] for row in rows], stored

    return of_levels


def test_the_next_session_starts_at_the_hardest_level_whose_goal_is_expected_to_be_reached(
    play: Any,
) -> None:
    first, stored = play()
    assert (first[0], stored) == (1, 1)
    levels, stored = play(2)
    assert levels[0] == stored == max(first) - 1


@pytest.mark.parametrize(
    ("attempts", "settings"),
    [(3, {"start_from": "last level"}), (2, {})],
    ids=["asked for", "two easy attempts give no estimate"],
)
def test_the_next_session_can_start_at_the_last_level(
    play: Any, attempts: int, settings: dict[str, Any]
) -> None:
    first, _ = play(1, attempts=attempts)
    levels, _ = play(2, **settings)
    assert levels[0] == first[-1] == attempts


@pytest.mark.slow
@pytest.mark.parametrize(
    ("settings", "level"),
    [
        ({"start_from": "fixed"}, 1),
        ({"start_level": 2}, 2),
        ({"max_level": 2}, 2),
        ({"difficulty_policy": "fixed"}, 1),
        ({"difficulty_policy": "percentile"}, 1),
        ({"threshold": 200.0, "start_level": 2, "start_from": "estimate"}, 2),
        ({"choice_set": "arrow keys"}, 1),
    ],
    ids=[
        *("fixed", "set for this session", "within the bounds", "left to the therapist"),
        *("left to the percentile", "no result reaches the goal", "something else is measured"),
    ],
)
def test_the_start_level_is_used_where_no_estimate_can_replace_it(
    play: Any, settings: dict[str, Any], level: int
) -> None:
    play()
    assert play(2, **settings)[0][0] == level


def test_a_start_level_is_replaced_if_an_estimate_is_asked_for(play: Any) -> None:
    play()
    assert play(2, start_level=2, start_from="estimate")[0][0] > 2


def test_after_a_change_of_the_goal_alone_the_level_follows_from_the_times_and_the_new_goal(
    play: Any,
) -> None:
    play()
    same, _ = play(2)
    harder, _ = play(3, threshold=850.0)
    assert 1 < harder[0] < same[0]


def test_a_simulated_session_always_starts_at_the_start_level(
    data: Path, catalogue: Catalogue, play: Any
) -> None:
    play()
    plan = make_plan(catalogue, "keyboard", ["P01"], FEW, seed=4, mode="simulated")
    session = simulate(plan, PEOPLE["average"], data, catalogue)
    with closing(connect(data)) as database:
        assert sessions.rows(database, "attempts", session)[0]["level"] == 1

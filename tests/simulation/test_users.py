"""The keyboard task adapts to three simulated users with twenty seeds."""

from contextlib import closing
from itertools import pairwise
from pathlib import Path
from statistics import fmean
from typing import NamedTuple

import pytest

from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import Plan, make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import connect

USERS = ("poor", "average", "competent")
SEEDS = range(1, 21)


def plan(keyboard: type[Task], seed: int, **parameters: object) -> Plan:
    return make_plan(Catalogue(), keyboard, ["SIM"], parameters, seed=seed, mode="simulated")


class Sample(NamedTuple):
    """A simulated session's rows."""

    user: str
    seed: int
    attempts: list[sessions.Row]
    trials: list[sessions.Row]

    @property
    def last_levels(self) -> list[int]:
        return [attempt["level"] for attempt in self.attempts[-10:]]


@pytest.fixture(
    scope="module",
    params=[
        pytest.param(SEEDS[:1], id="few"),
        pytest.param(SEEDS, id="all", marks=pytest.mark.slow),
    ],
)
def samples(
    request: pytest.FixtureRequest,
    tmp_path_factory: pytest.TempPathFactory,
    catalogue: Catalogue,
    keyboard: type[Task],
) -> list[Sample]:
    """A session of each user with each seed."""
    data = tmp_path_factory.mktemp("users")
    made = [
        (user, seed, simulate(plan(keyboard, seed), PEOPLE[user], data, catalogue))
        for user in USERS
        for seed in request.param
    ]
    database = connect(data)
    return [
        Sample(
            user,
            seed,
            sessions.rows(database, "attempts", session),
            sessions.rows(database, "trials", session),
        )
        for user, seed, session in made
    ]


@pytest.mark.slow
def test_every_session_is_whole(samples: list[Sample]) -> None:
    for sample in samples:
        assert [attempt["attempt"] for attempt in sample.attempts] == list(range(1, 21))
        numbers = [(trial["attempt"], trial["trial"]) for trial in sample.trials]
        assert numbers == [(attempt, trial) for attempt in range(1, 21) for trial in range(1, 21)]


def test_the_better_the_user_the_higher_the_level_they_end_at(samples: list[Sample]) -> None:
    for seed in {sample.seed for sample in samples}:
        mean = {sample.user: fmean(sample.last_levels) for sample in samples if sample.seed == seed}
        assert mean["competent"] > mean["average"] > mean["poor"], seed


def test_the_average_user_crosses_the_threshold_both_ways(samples: list[Sample]) -> None:
    for sample in (sample for sample in samples if sample.user == "average"):
        metrics = [attempt["metric"] for attempt in sample.attempts]
        crossings = {(before < 1000, after < 1000) for before, after in pairwise(metrics)}
        assert {(True, False), (False, True)} <= crossings, sample.seed


def test_nobody_spends_over_half_of_the_last_ten_attempts_at_a_bound(samples: list[Sample]) -> None:
    for sample in samples:
        for bound in (1, 20):
            assert sample.last_levels.count(bound) <= 5, (sample.user, sample.seed, bound)


def test_the_same_seed_twice_is_the_same_to_the_last_nanosecond(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    first, again, another = (
        simulate(plan(keyboard, seed, attempts=4), PEOPLE["poor"], data, catalogue)
        for seed in (7, 7, 8)
    )
    with closing(connect(data)) as database:
        histories = [list(sessions.history(database, name)) for name in (first, again, another)]
    assert first != again
    assert len(histories[0]) > 400
    assert histories[0] == histories[1]
    assert histories[0] != histories[2]


def test_a_simulated_session_says_that_it_is_one_and_enters_no_participant(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    progress: list[int] = []
    session = simulate(
        plan(keyboard, 1, attempts=3), PEOPLE["average"], data, catalogue, progress.append
    )
    row = sessions.find(connect(data), data, session)
    assert (row["mode"], row["status"], row["attempts"], row["participant"]) == (
        "simulated",
        "completed",
        3,
        "SIM",
    )
    assert set(row["software"]) >= {"sar_tui", "python", "task", "theme"}
    assert connect(data).execute("SELECT * FROM participants").fetchall() == []
    assert progress == [1, 2, 3]

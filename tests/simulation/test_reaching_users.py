"""The reaching task adapts to three simulated users, and every row can be reanalysed."""

from contextlib import closing
from pathlib import Path
from statistics import fmean
from typing import Any, NamedTuple

import msgspec
import pytest

from sar_tui.loop.task import Task
from sar_tui.loop.topics import IMU
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import Performance
from sar_tui.model.units import MS
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import Plan, make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE, Person
from sar_tui.store import imu, sessions
from sar_tui.store.database import connect
from tests.tasks.reaching.reaching_driver import analysed_again

USERS = ("poor", "average", "competent")
ATTEMPTS = 10


def reaching() -> type[Task]:
    return Catalogue().task("reaching")


def plan(seed: int, **parameters: object) -> Plan:
    return make_plan(Catalogue(), reaching(), ["SIM"], parameters, seed=seed, mode="simulated")


class Sample(NamedTuple):
    """A simulated session's rows, and where they are."""

    data: Path
    session: str
    attempts: list[sessions.Row]
    trials: list[sessions.Row]

    def mean_at_nearest_marker(self, field: str) -> float:
        details = [trial["details"] for trial in self.trials if trial["correct"]]
        return fmean(found[field] for found in details if found["marker_cm"] == 15.0)


@pytest.fixture(scope="module")
def samples(tmp_path_factory: pytest.TempPathFactory, catalogue: Catalogue) -> dict[str, Sample]:
    """A session of each user."""
    data = tmp_path_factory.mktemp("reaching")
    found = {}
    with pytest.MonkeyPatch.context() as patch, closing(connect(data)) as database:
        # The same samples in fewer blocks, because making many small blocks takes time.
        patch.setattr("sar_tui.inputs.simulated.STEP", 80 * MS)
        patch.setattr("sar_tui.inputs.sensor.DRAIN", 80 * MS)
        for user in USERS:
            session = simulate(plan(1, attempts=ATTEMPTS), PEOPLE[user], data, catalogue)
            attempts, trials = (
                sessions.rows(database, table, session) for table in ("attempts", "trials")
            )
            found[user] = Sample(data, session, attempts, trials)
    return found


def test_every_session_is_whole_and_holds_its_sensor(samples: dict[str, Sample]) -> None:
    numbers = range(1, ATTEMPTS + 1)
    for sample in samples.values():
        assert [attempt["attempt"] for attempt in sample.attempts] == list(numbers)
        done = [(trial["attempt"], trial["trial"]) for trial in sample.trials]
        assert done == [(number, 1) for number in numbers]
        with closing(connect(sample.data)) as database:
            (stream,) = sessions.rows(database, "imu_streams", sample.session)
        assert (stream["source"], stream["run"]) == ("simulated", 1)


def test_the_better_the_user_the_farther_faster_and_smoother_they_reach(
    samples: dict[str, Sample],
) -> None:
    poor, average, competent = (samples[user] for user in USERS)
    levels = [
        fmean(attempt["level"] for attempt in sample.attempts[-6:])
        for sample in (poor, average, competent)
    ]
    assert levels == sorted(set(levels))
    times = [
        sample.mean_at_nearest_marker("reach_time_ms") for sample in (competent, average, poor)
    ]
    assert times == sorted(set(times))
    assert competent.mean_at_nearest_marker("sparc") > poor.mean_at_nearest_marker("sparc")


def test_every_row_can_be_made_again_from_the_kept_samples(samples: dict[str, Sample]) -> None:
    for sample in samples.values():
        with closing(connect(sample.data)) as database:
            for trial in sample.trials:
                kept = trial["details"]
                window = kept["window_from_ns"], kept["window_to_ns"]
                measured = imu.samples(database, sample.session, *window, trial["run"])
                found = analysed_again(measured, kept)
                assert found.details.items() <= kept.items()
                if trial["correct"]:
                    times = trial["onset_ns"], trial["response_ns"]
                    assert (found.onset_ns, found.end_ns) == times


@pytest.mark.usefixtures("fewer_blocks")
def test_the_same_seed_twice_is_the_same_to_the_last_nanosecond_and_sample(
    data: Path, catalogue: Catalogue
) -> None:
    settings: dict[str, Any] = {"attempts": 2, "go_signal": True, "feedback_on": "both"}
    first, again, another = (
        simulate(plan(seed, **settings), PEOPLE["poor"], data, catalogue) for seed in (7, 7, 8)
    )
    with closing(connect(data)) as database:
        histories = [list(sessions.history(database, name)) for name in (first, again, another)]
    assert first != again
    assert any(record.topic is IMU for record in histories[0])
    assert histories[0] == histories[1]
    assert histories[0] != histories[2]


class Tiring(Person, frozen=True):
    """A person whose hand halts on its way from an attempt on, and not before."""

    from_attempt: int = 0

    def perform(self, choices: int, attempt: int, streams: RandomStreams) -> Performance:
        usual = super().perform(choices, attempt, streams)
        return Performance(
            usual.reaction_ms, False, 2.0, unsteadiness=float(attempt >= self.from_attempt)
        )


@pytest.mark.usefixtures("fewer_blocks")
def test_feedback_asks_for_another_way_to_move_once_it_is_worse_and_speaks_of_the_result_before(
    data: Path, catalogue: Catalogue
) -> None:
    settings = {
        "feedback_on": "performance",
        "feedback_form": "qualitative",
        "reaches_per_attempt": 2,
    }
    tiring = Tiring(**msgspec.structs.asdict(PEOPLE["average"]), from_attempt=9)
    session = simulate(
        plan(3, attempts=11, difficulty_policy="fixed", **settings), tiring, data, catalogue
    )
    words = [
        action["final"]["text"]
        for action in sessions.rows(connect(data), "actions", session)
        if action["kind"] == "feedback"
    ]
    asked = [any(quality.aim in said for quality in reaching().qualities) for said in words]
    assert asked[:9] == [False] * 9
    assert any(asked[9:]), words
    assert not any(" ms" in said for said in words)

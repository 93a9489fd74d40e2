"""The reaching task adapts to three simulated users, and every row can be reanalysed."""

from itertools import pairwise
from pathlib import Path
from statistics import fmean
from typing import Any, NamedTuple

import msgspec
import pytest

from sar_tui.loop.task import Task
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import Performance
from sar_tui.model.units import MS
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import Plan, make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE, Person
from sar_tui.store import imu, sessions
from sar_tui.store.database import connect
from tests.examples import first
from tests.tasks.reaching.reaching_driver import analysed_again

USERS = ("poor", "average", "competent")
SEEDS = (1, 2)
ATTEMPTS = 10
GOALS = [round(1200 * (far / 15) ** 0.5) for far in (15, 20, 25, 30, 35, 40)]


def reaching() -> type[Task]:
    return Catalogue().task("reaching")


def plan(seed: int, **parameters: object) -> Plan:
    return make_plan(Catalogue(), reaching(), ["SIM"], parameters, seed=seed, mode="simulated")


class Sample(NamedTuple):
    """A simulated session's rows, and where they are."""

    user: str
    seed: int
    data: Path
    session: str
    attempts: list[sessions.Row]
    trials: list[sessions.Row]

    def of(self, attempt: sessions.Row) -> list[sessions.Row]:
        return [trial for trial in self.trials if trial["attempt"] == attempt["attempt"]]


@pytest.fixture(
    scope="module",
    params=[
        pytest.param(SEEDS[:1], id="few"),
        pytest.param(SEEDS, id="all", marks=pytest.mark.slow),
    ],
)
def samples(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory, catalogue: Catalogue
) -> list[Sample]:
    """A session of each user with each seed."""
    data = tmp_path_factory.mktemp("reaching")
    with pytest.MonkeyPatch.context() as patch:
        # The same samples in fewer blocks, because making many small blocks takes time.
        if request.param != SEEDS:
            patch.setattr("sar_tui.inputs.simulated.STEP", 80 * MS)
            patch.setattr("sar_tui.inputs.sensor.DRAIN", 80 * MS)
        made = [
            (user, seed, simulate(plan(seed, attempts=ATTEMPTS), PEOPLE[user], data, catalogue))
            for user in USERS
            for seed in request.param
        ]
    database = connect(data)
    return [
        Sample(
            user,
            seed,
            data,
            session,
            sessions.rows(database, "attempts", session),
            sessions.rows(database, "trials", session),
        )
        for user, seed, session in made
    ]


def test_every_session_is_whole(samples: list[Sample]) -> None:
    assert len(samples) in (3, 6)
    for sample in samples:
        assert [attempt["attempt"] for attempt in sample.attempts] == list(range(1, ATTEMPTS + 1))
        assert [(trial["attempt"], trial["trial"]) for trial in sample.trials] == [
            (attempt, 1) for attempt in range(1, ATTEMPTS + 1)
        ]


def test_the_better_the_user_the_farther_the_marker_they_end_at(samples: list[Sample]) -> None:
    for seed in {sample.seed for sample in samples}:
        mean = {
            s.user: fmean(a["level"] for a in s.attempts[-6:]) for s in samples if s.seed == seed
        }
        assert mean["competent"] > mean["average"] > mean["poor"]


def test_the_better_the_user_the_smoother_and_faster_they_reach_to_the_same_marker(
    samples: list[Sample],
) -> None:
    def mean(user: str, field: str) -> float:
        details = [
            t["details"] for s in samples if s.user == user for t in s.trials if t["correct"]
        ]
        return fmean(d[field] for d in details if d["marker_cm"] == 15.0)

    assert (
        mean("competent", "reach_time_ms")
        < mean("average", "reach_time_ms")
        < mean("poor", "reach_time_ms")
    )
    assert mean("competent", "sparc") > mean("poor", "sparc")


@pytest.mark.parametrize("user", USERS)
def test_the_outcome_and_the_feedback_of_every_attempt_follow_from_its_trials(
    samples: list[Sample], user: str
) -> None:
    for sample in (sample for sample in samples if sample.user == user):
        for attempt in sample.attempts:
            trials = sample.of(attempt)
            times = [(t["response_ns"] - t["onset_ns"]) / 1e6 for t in trials if t["correct"]]
            accuracy = len(times) / len(trials)
            mean = fmean(times) if times else None
            goal = GOALS[attempt["level"] - 1]
            if accuracy < 0.8 or mean is None:
                expected = ("failure", "negative")
            elif mean < goal:
                expected = ("success", "neutral" if mean >= goal * 0.98 else "positive")
            else:
                expected = ("failure", "neutral" if mean <= goal * 1.02 else "negative")
            assert attempt["goal"] == goal
            assert attempt["metric"] == (None if mean is None else pytest.approx(mean, abs=0.001))
            assert attempt["accuracy"] == accuracy
            assert (attempt["outcome"], attempt["feedback"]) == expected


def test_the_qualities_of_an_attempt_are_the_means_of_its_reaches(samples: list[Sample]) -> None:
    for sample in samples:
        for attempt in sample.attempts:
            done = [trial["details"] for trial in sample.of(attempt) if trial["correct"]]
            for field, value in attempt["qualities"].items():
                assert value == pytest.approx(fmean(d[field] for d in done if d[field] is not None))
            if done:
                assert set(attempt["qualities"]) >= {"sparc", "movement_units"}


def test_the_level_follows_the_outcome_by_one_within_its_bounds(samples: list[Sample]) -> None:
    for sample in samples:
        assert sample.attempts[0]["level"] == 1
        for attempt, following in pairwise(sample.attempts):
            step = 1 if attempt["outcome"] == "success" else -1
            assert following["level"] == min(6, max(1, attempt["level"] + step))


def test_every_row_can_be_made_again_from_the_kept_samples(samples: list[Sample]) -> None:
    for sample in samples:
        database = connect(sample.data)
        for trial in sample.trials:
            kept = trial["details"]
            measured = imu.samples(
                database, sample.session, kept["window_from_ns"], kept["window_to_ns"], trial["run"]
            )
            found = analysed_again(measured, kept)
            assert found.details.items() <= kept.items()
            if trial["correct"]:
                assert (found.onset_ns, found.end_ns) == (trial["onset_ns"], trial["response_ns"])


def events(data: Path, session: str) -> list[tuple[object, ...]]:
    query = "SELECT seq, run, at_ns, topic, message FROM events WHERE session=? ORDER BY seq"
    return list(connect(data).execute(query, (session,)))


def chunks(data: Path, session: str) -> list[tuple[object, ...]]:
    query = (
        "SELECT stream, seq, n, before_event, at_ns, data FROM imu_chunks WHERE session=? "
        "ORDER BY stream, seq"
    )
    return list(connect(data).execute(query, (session,)))


@pytest.mark.parametrize("user", first(1, USERS))
def test_the_same_seed_twice_is_the_same_to_the_last_nanosecond_and_sample(
    user: str, data: Path, catalogue: Catalogue
) -> None:
    parameters: dict[str, Any] = {"attempts": 2, "go_signal": True, "feedback_on": "both"}
    first, again, another = (
        simulate(plan(seed, **parameters), PEOPLE[user], data, catalogue) for seed in (7, 7, 8)
    )
    assert first != again
    assert len(events(data, first)) > 50
    assert events(data, first) == events(data, again)
    assert chunks(data, first) == chunks(data, again)
    assert events(data, first) != events(data, another)


@pytest.mark.usefixtures("fewer_blocks")
def test_with_a_signal_to_go_every_user_has_reaction_times(
    data: Path, catalogue: Catalogue
) -> None:
    for user in USERS:
        session = simulate(plan(3, attempts=2, go_signal=True), PEOPLE[user], data, catalogue)
        times = [
            trial["reaction_time_ms"] for trial in sessions.rows(connect(data), "trials", session)
        ]
        assert all(100 < time < 3000 for time in times if time is not None)
        assert any(times)


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


def test_a_simulated_session_holds_its_sensor(samples: list[Sample]) -> None:
    for sample in samples:
        (stream,) = sessions.rows(connect(sample.data), "imu_streams", sample.session)
        assert (stream["source"], stream["run"]) == ("simulated", 1)
        assert msgspec.json.decode(stream["layout"])[0][0] == "at"

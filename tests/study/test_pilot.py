"""Numbers of a power analysis from a pilot study."""

import random
import sqlite3
import statistics
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import in_session, population
from sar_tui.store.database import StoreError, connect_unchanged
from sar_tui.study.outcome import Outcome
from sar_tui.study.pilot import Moments, from_pilot, moments

OUTCOME = Outcome(measure="metric", visit="second", block="training", compared="groups")


def drawn(people: int, sizes: Sequence[int], seed: int) -> list[list[list[float]]]:
    """Return people with a mean of 400 and SDs of 40, 20 and 70. ``sizes``: trials in each of
    their sessions; every third person has one session less.
    """
    source = random.Random(seed)
    found = []
    for number in range(people):
        person = source.gauss(400, 40)
        sessions = [(source.gauss(person, 20), n) for n in sizes[: len(sizes) - (number % 3 == 0)]]
        found.append([[source.gauss(session, 70) for _ in range(n)] for session, n in sessions])
    return found


def test_the_parts_of_the_variance_are_found() -> None:
    found = moments(drawn(3000, (40, 20, 10), seed=1))
    assert found.mean == pytest.approx(400, abs=3)
    assert found.person_sd == pytest.approx(40, rel=0.05)
    assert found.session_sd == pytest.approx(20, rel=0.05)
    assert found.trial_sd == pytest.approx(70, rel=0.02)


def test_the_method_is_unbiased_in_small_studies() -> None:
    many = [moments(drawn(6, (12, 5), seed)) for seed in range(500)]
    assert statistics.fmean(each.trial_sd**2 for each in many) == pytest.approx(4900, rel=0.05)
    assert statistics.fmean(each.person_sd**2 for each in many) == pytest.approx(1600, rel=0.15)


def test_balanced_numbers_are_those_of_the_analysis_of_variance() -> None:
    people = [[[1.0, 3.0], [4.0, 8.0]], [[10.0, 12.0], [15.0, 11.0]], [[5.0, 6.0], [2.0, 3.0]]]
    means = [[statistics.fmean(session) for session in each] for each in people]
    trial = statistics.fmean(statistics.variance(session) for each in people for session in each)
    session = statistics.fmean(statistics.variance(each) for each in means) - trial / 2
    own = [statistics.fmean(each) for each in means]
    person = statistics.variance(own) - session / 2 - trial / 4
    found = moments(people)
    expected = Moments(statistics.fmean(own), person**0.5, session**0.5, trial**0.5)
    assert found == pytest.approx(expected)


def test_a_negative_part_is_none() -> None:
    alike = [[[1.0, 9.0], [9.0, 1.0]], [[2.0, 8.0], [8.0, 2.0]]]
    assert moments(alike)[1:3] == (0, 0)


def test_sessions_of_one_value_have_no_variance_of_trials() -> None:
    found = moments([[[1.0], [3.0]], [[11.0], [13.0]]])
    assert (found.trial_sd, found.session_sd) == (0, pytest.approx(2**0.5))


# --- from a database


@pytest.fixture(scope="module")
def pilot(
    tmp_path_factory: pytest.TempPathFactory, catalogue: Catalogue, keyboard: type[Task]
) -> Path:
    """A data folder with simulated sessions: six people twice, one once."""
    folder = tmp_path_factory.mktemp("pilot")
    people = population(7, seed=5)
    for number, person in enumerate(people):
        for session in range(2 if number < 6 else 1):
            seed = 100 * number + session
            plan = make_plan(
                catalogue,
                keyboard,
                [f"P{number}"],
                {"attempts": 3, "practice_attempts": 1, "prompts_per_attempt": 4},
                seed=seed,
                mode="simulated",
            )
            simulate(plan, in_session(person, seed), folder, catalogue)
    return folder


@pytest.fixture
def database(pilot: Path) -> Iterator[sqlite3.Connection]:
    with closing(connect_unchanged(pilot)) as opened:
        yield opened


def test_right_trials_of_simulated_sessions_are_counted(database: sqlite3.Connection) -> None:
    found = from_pilot(database, ["keyboard"], OUTCOME, "ms", simulated=True)
    (right,) = database.execute(
        "SELECT count(*) FROM trials JOIN attempts USING (session, attempt, seat)"
        " WHERE NOT practice AND trials.correct"
    ).fetchone()
    assert (found.people, found.sessions, found.trials) == (7, 13, right)
    numbers = {name: number.value for name, number in found.numbers.items()}
    assert 400 < numbers["mean"] < 1200
    assert 100 < numbers["trial_sd"] < 260
    assert numbers["trials"] == round(right / 13)
    assert {number.source for number in found.numbers.values()} == {
        f"pilot: 7 people, 13 sessions, {right} trials"
    }
    assert "7 people, 13 sessions" in found.sentence
    assert "uncertain by 29 % or more" in found.sentence


@pytest.mark.parametrize("measure", ["accuracy", "level", "success_rate"])
def test_other_measures_are_those_of_attempts(database: sqlite3.Connection, measure: str) -> None:
    outcome = Outcome(measure=measure, visit="second", block="training", compared="within")
    found = from_pilot(database, ["keyboard"], outcome, "", simulated=True)
    assert found.trials == 13 * 3


@pytest.mark.parametrize(
    ("tasks", "unit", "simulated", "said"),
    [
        (
            ["keyboard"],
            "ms",
            False,
            "needs 5 people with two sessions of keyboard, and this one has 0",
        ),
        (["flanker", "nback"], "ms", True, "two sessions of flanker or nback, and this one has 0."),
        (
            ["keyboard"],
            "s",
            True,
            "[power] unit is 's', and the pilot study's results are in 'ms'.",
        ),
    ],
)
def test_a_pilot_that_cannot_tell_is_refused(
    database: sqlite3.Connection, tasks: list[str], unit: str, simulated: bool, said: str
) -> None:
    with pytest.raises(StoreError) as refusal:
        from_pilot(database, tasks, OUTCOME, unit, simulated=simulated)
    assert said in str(refusal.value)


def test_the_score_of_a_form_is_not_estimated(database: sqlite3.Connection) -> None:
    outcome = Outcome(measure="sus.score", visit="second", compared="groups")
    with pytest.raises(StoreError, match=r"state those of sus.score in \[power\]"):
        from_pilot(database, [], outcome, "")


def test_a_pilot_study_is_not_changed(pilot: Path, database: sqlite3.Connection) -> None:
    with pytest.raises(sqlite3.OperationalError, match="readonly"):
        database.execute("DELETE FROM trials")
    with pytest.raises(StoreError, match="has no database that can be read"):
        connect_unchanged(pilot / "elsewhere")
    assert not (pilot / "elsewhere").exists()

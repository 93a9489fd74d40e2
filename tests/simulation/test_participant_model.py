"""Simulated reaction times are realistic and reproducible."""

import statistics
from itertools import pairwise

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.model.random_streams import RandomStreams
from sar_tui.simulation.participant_model import (
    MEAN_MS,
    PEOPLE,
    PERSON_SD_MS,
    SESSION_SD_MS,
    Person,
    drawn,
    in_session,
    population,
)

STEADY = Person(
    "steady", 300, 150, sigma_ms=80, tau_ms=120, errors=0.1, misses=0.05, practice=0, fatigue=0
)


def draws(person: Person, choices: int = 4, attempt: int = 1, count: int = 4000) -> list[float]:
    return [
        person.reaction_ms(choices, attempt, RandomStreams(9, attempt, trial))
        for trial in range(count)
    ]


@pytest.mark.parametrize("person", PEOPLE.values(), ids=PEOPLE)
def test_reaction_time_grows_by_the_same_for_each_bit_of_choice(person: Person) -> None:
    means = [person.mean_ms(2**bits, 1) for bits in range(7)]
    steps = {round(later - earlier, 6) for earlier, later in pairwise(means)}
    assert steps == {person.per_bit_ms}


def test_with_no_choice_the_base_time_is_left() -> None:
    assert STEADY.mean_ms(1, 1) == STEADY.mean_ms(0, 1) == 300


@pytest.mark.parametrize("choices", [2, 8, 32])
def test_reaction_times_have_the_mean_and_spread_that_were_asked_for(choices: int) -> None:
    times = draws(STEADY, choices)
    assert statistics.mean(times) == pytest.approx(STEADY.mean_ms(choices, 1), rel=0.03)
    assert statistics.stdev(times) == pytest.approx((80**2 + 120**2) ** 0.5, rel=0.08)


def test_reaction_times_have_a_tail_to_the_slow_side() -> None:
    times = draws(STEADY)
    mean, deviation = statistics.mean(times), statistics.stdev(times)
    skewness = statistics.mean(((time - mean) / deviation) ** 3 for time in times)
    assert skewness == pytest.approx(2 * 120**3 / (80**2 + 120**2) ** 1.5, abs=0.25)


@given(st.integers(0, 10**6), st.integers(1, 80), st.integers(1, 200))
def test_nobody_reacts_faster_than_a_choice_can_be(seed: int, choices: int, attempt: int) -> None:
    for person in PEOPLE.values():
        assert person.reaction_ms(choices, attempt, RandomStreams(seed)) >= 120


def test_practice_helps_at_first_and_fatigue_slows_later() -> None:
    person = PEOPLE["average"]
    means = [person.mean_ms(4, attempt) for attempt in range(1, 101)]
    assert means[4] < means[0]
    assert means[99] > means[19]


def test_errors_and_misses_come_as_often_as_they_should() -> None:
    chances = [RandomStreams(2, trial) for trial in range(6000)]
    assert sum(map(STEADY.slips, chances)) / 6000 == pytest.approx(0.1, abs=0.015)
    assert sum(map(STEADY.misses_it, chances)) / 6000 == pytest.approx(0.05, abs=0.015)


def test_the_same_moment_is_the_same_each_time_and_each_person_is_their_own() -> None:
    for person in PEOPLE.values():
        assert draws(person, count=5) == draws(person, count=5)
    assert len({tuple(draws(person, count=5)) for person in PEOPLE.values()}) == 3


# --- people who differ


def test_people_differ_as_published_and_stay_the_same() -> None:
    people = population(2000, seed=4)
    model = PEOPLE["average"]
    means = [person.mean_ms(4, 1) / model.mean_ms(4, 1) for person in people]
    assert statistics.mean(means) == pytest.approx(1, abs=0.01)
    assert statistics.stdev(means) == pytest.approx(PERSON_SD_MS / MEAN_MS, rel=0.05)
    assert population(3, seed=4) == people[:3]
    assert population(3, seed=5) != people[:3]


def test_a_person_differs_from_session_to_session() -> None:
    person = drawn(PEOPLE["competent"], seed=1)
    sessions = [in_session(person, seed) for seed in range(2000)]
    means = [session.base_ms / person.base_ms for session in sessions]
    assert statistics.stdev(means) == pytest.approx(SESSION_SD_MS / MEAN_MS, rel=0.05)
    assert sessions[0] == in_session(person, 0)
    assert person != PEOPLE["competent"]
    assert (
        msgspec.structs.replace(
            person, base_ms=PEOPLE["competent"].base_ms, per_bit_ms=PEOPLE["competent"].per_bit_ms
        )
        == PEOPLE["competent"]
    )

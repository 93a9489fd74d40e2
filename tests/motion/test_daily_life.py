"""Simulated daily life: what a sensor on the wrist measures follows from one orientation, and
nothing has a rhythm of its own.
"""

import itertools

import numpy as np
import pytest

from sar_tui.motion.quaternions import angle, conjugate, integrate, multiply, rotate
from sar_tui.motion.synthesis import GRAVITY_M_S2
from tests.motion.daily_life import BACK_DEG, KINDS, TRIP_S, DailyLife, simulate
from tests.motion.wrist_motion import WristMotion


@pytest.fixture(scope="module")
def lives() -> dict[str, DailyLife]:
    return {kind: simulate(kind, 1, minutes=2.0) for kind in KINDS}


def test_the_same_seed_is_the_same_life_and_another_seed_another() -> None:
    one, again, other = (simulate("typing", seed, minutes=0.2).recording for seed in (1, 1, 2))
    assert np.array_equal(one.rate, again.rate)
    assert not np.array_equal(one.rate, other.rate)


@pytest.mark.parametrize("rate_hz", [50.0, 100.0, 250.0])
def test_a_life_has_as_many_samples_as_its_sensor_takes(rate_hz: float) -> None:
    recording = simulate("sitting", 1, minutes=0.5, rate_hz=rate_hz).recording
    assert (len(recording.time_s), recording.rate_hz) == (30 * rate_hz, pytest.approx(rate_hz))


def test_gravity_turns_with_the_orientation_that_the_gyroscope_measures() -> None:
    motion = WristMotion(20.0, 100.0, np.random.default_rng(1))
    motion.rest((10.0, -20.0, 30.0))
    motion.shift(8.0, (0.0, 50.0, 40.0), 1.0)
    measured = motion.measured()
    bias = measured.rate[:500].mean(axis=0)
    turned = integrate(measured.rate - bias, 0.01)
    assert measured.acceleration is not None
    before, after = (
        measured.acceleration[part].mean(axis=0) for part in (slice(0, 500), slice(1200, 1700))
    )
    assert np.linalg.norm(before) == pytest.approx(GRAVITY_M_S2, rel=0.01)
    foreseen = rotate(conjugate(turned[1450]), rotate(turned[250], before))
    assert (
        np.degrees(np.arccos(foreseen @ after / np.linalg.norm(foreseen) / np.linalg.norm(after)))
        < 1.0
    )


def test_the_accelerometer_feels_gravity_on_average_in_every_life(
    lives: dict[str, DailyLife],
) -> None:
    for life in lives.values():
        assert life.recording.acceleration is not None
        felt = np.linalg.norm(life.recording.acceleration, axis=1)
        assert np.median(felt) == pytest.approx(GRAVITY_M_S2, rel=0.1)


def test_a_trip_ends_where_it_began(lives: dict[str, DailyLife]) -> None:
    trips = [(life, trip) for life in lives.values() for trip in life.trips]
    assert len(trips) > 4
    for life, trip in trips:
        recording = life.recording
        assert trip.to_s - trip.from_s <= TRIP_S
        first, last = np.searchsorted(recording.time_s, (trip.from_s, trip.to_s))
        turned = integrate(recording.rate[first:last], 0.01)
        left = np.degrees(angle(multiply(conjugate(turned[0]), turned[-1])))
        assert left < 3 * BACK_DEG, "small movements meanwhile and the sensor's bias come on top"


def test_walking_and_tremor_have_the_frequencies_of_people(lives: dict[str, DailyLife]) -> None:
    for kind, low, high in (
        ("walking", 0.75, 1.05),
        ("wheelchair", 0.7, 1.2),
        ("tremor", 4.0, 6.0),
    ):
        rate = lives[kind].recording.rate
        frequency = np.fft.rfftfreq(len(rate), 0.01)
        power = (np.abs(np.fft.rfft(rate - rate.mean(axis=0), axis=0)) ** 2).sum(axis=1)
        assert low < frequency[power.argmax()] < high


def test_events_come_at_no_fixed_times() -> None:
    onsets = [trip.from_s for trip in simulate("scratching", 3, minutes=5.0).trips]
    between = np.diff(onsets)
    assert len(between) > 5
    assert between.std() > 0.3 * between.mean()
    others = [simulate(kind, 4, minutes=2.0).trips for kind in ("scratching", "typing")]
    assert all(set(one).isdisjoint(other) for one, other in itertools.combinations(others, 2))

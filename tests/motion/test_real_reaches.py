"""Reaches of people (``tests/data/real-reaches``), and simulated ones with what patients add to them:
tremor at rest, the trunk, parts, and a hold at the target.

The figures are those of ``python -m benchmarks reaches``, with a margin.
"""

import msgspec
import numpy as np
import pytest

from benchmarks import reaches
from benchmarks.real_recordings import (
    DAILY_LIFE,
    EXERCISES,
    labels,
    read_daily_life,
    read_exercise,
)
from sar_tui.motion.detection import calibrated, detect
from sar_tui.motion.imperfections import StrappedSensor
from sar_tui.motion.orientation import OrientationParameters
from sar_tui.motion.reach import Reach
from sar_tui.motion.reach_kinds import KINDS
from sar_tui.motion.synthesis import PROFILES, ReachShape, simulate
from sar_tui.motion.trajectories import SimulatedReaches, simulate_reaches
from tests.examples import first
from tests.motion.wrist_motion import WristMotion

BY_EYE = ("s1_e8_u2", "s4_e6_u2")


def totals(kinds: list[reaches.Kind]) -> tuple[float, float, float]:
    """Return the share that was found, false ones a minute, and the median error of ends, s."""
    found, count = sum(kind.found for kind in kinds), sum(kind.reaches for kind in kinds)
    false, minutes = sum(kind.false for kind in kinds), sum(kind.minutes for kind in kinds)
    ends = [off for kind in kinds for off in kind.end_s]
    return found / count, false / minutes if minutes else 0.0, float(np.nanmedian(ends))


def in_the_open(name: str) -> list[reaches.Kind]:
    return list(reaches.in_the_open(name, reaches.OURS, reaches.DETECTORS[reaches.OURS]))


@pytest.mark.parametrize("name", BY_EYE)
def test_every_reach_that_was_labelled_by_eye_is_found_and_no_other(name: str) -> None:
    share, false, end_s = totals(in_the_open(name))
    assert (share, false) == (1.0, 0.0)
    assert abs(end_s) <= 0.2
    share, _, end_s = totals(list(reaches.in_windows(name, reaches.OURS)))
    assert share == 1.0
    assert abs(end_s) <= 0.2


@pytest.mark.parametrize("person", first(1, "2451"))
def test_nine_of_ten_reaches_of_each_person_are_found(person: str) -> None:
    own = [kind for name in EXERCISES if name[1] == person for kind in in_the_open(name)]
    share, false, end_s = totals(own)
    assert share >= 0.9
    assert false <= 0.5
    assert abs(end_s) <= 0.3


@pytest.mark.parametrize("people", first(1, [DAILY_LIFE[:2], DAILY_LIFE[2:]]))
def test_people_who_sit_walk_and_turn_hardly_reach(people: tuple[str, ...]) -> None:
    recordings = [read_daily_life(name) for name in people]
    minutes = sum(float(one.time_s[-1] - one.time_s[0]) for one in recordings) / 60
    assert sum(len(detect(one)) for one in recordings) <= 0.5 * minutes


@pytest.mark.parametrize("name", BY_EYE)
def test_a_hold_of_seconds_at_the_target_is_a_part_of_the_reach(name: str) -> None:
    (part,) = labels(name)
    found = detect(read_exercise(name))
    for label in part.reaches:
        (one,) = [reach for reach in found if reach.onset_s < label.departure_s < reach.end_s]
        assert one.dwell_s == pytest.approx(label.departure_s - label.arrival_s, abs=0.9)


@pytest.mark.parametrize("tremor_hz", first(2, [3.0, 5.0, 7.0]))
def test_a_tremor_at_rest_is_no_reach_and_hides_none(tremor_hz: float) -> None:
    """Parkinsonian tremor at rest, at 3 to 7 Hz, turns the forearm by degrees (Deuschl, Bain & Brin
    1998, Mov Disord 13 S3:2-23).
    """
    shaking = WristMotion(60.0, 100.0, np.random.default_rng(3))
    shaking.rhythm(5.0, 55.0, tremor_hz, (0.5, 0.7, 2.0), frequency_cv=0.04, amplitude_cv=0.5)
    assert detect(shaking.measured()) == ()

    reaching = WristMotion(40.0, 100.0, np.random.default_rng(3))
    reaching.rhythm(1.0, 39.0, tremor_hz, (0.5, 0.7, 2.0), frequency_cv=0.04, amplitude_cv=0.5)
    truth = [(at_s, at_s + 2.5) for at_s in (6.0, 14.0, 22.0, 30.0)]
    for at_s, end_s in truth:
        reaching.shift(at_s, (25.0, 30.0, 0.0), 0.9)
        reaching.shift(end_s - 0.9, (-25.0, -30.0, 0.0), 0.9)
    times = [(reach.onset_s, reach.end_s) for reach in detect(reaching.measured())]
    assert times == [pytest.approx(each, abs=0.15) for each in truth]

    shaken = msgspec.structs.replace(PROFILES["tremor"], tremor_hz=tremor_hz)
    shape = ReachShape(out_s=0.8, back_s=0.8, dwell_s=0.5)
    (found,) = detect(simulate([shape], shaken).recording)
    assert (found.onset_s, found.end_s) == pytest.approx((2.0, 4.1), abs=0.12)


@pytest.mark.parametrize("tremor_hz", first(2, [4.0, 6.0, 9.0]))
def test_a_reach_with_a_tremor_in_action_is_found(tremor_hz: float) -> None:
    """Essential tremor lies at 4 to 12 Hz (Luft et al. 2019, Sensors 19:4301). One of 4 cm from end
    to end moves a hand 40 cm from the elbow by 2.9° to either side.
    """
    shaking = StrappedSensor(
        action_tremor_hz=tremor_hz, action_tremor_rad_s=np.radians(2.9) * 2 * np.pi * tremor_hz
    )
    made = [simulate_reaches(kind, 5, count=4, imperfections=shaking) for kind in KINDS]
    share, _, end_s = totals([found_of(each) for each in made])
    assert share >= 0.9
    assert abs(end_s) <= 0.15


def found_of(made: SimulatedReaches) -> reaches.Kind:
    """Return what is found of simulated reaches."""
    found = [(reach.onset_s, reach.end_s) for reach in detect(made.recording)]
    pairs = [
        (times, truth)
        for truth in made.truth
        for times in found
        if reaches.overlap(times, truth) >= reaches.SHARED
    ]
    onset_s, end_s = ([times[at] - truth[at] for times, truth in pairs] for at in (0, 1))
    return reaches.Kind(
        "", "", len(made.truth), len(pairs), len(found) - len(pairs), 1, onset_s, end_s
    )


def ends_of(kind: str, seeds: range) -> list[float]:
    """Return the errors of the ends of simulated reaches, which must all be found, and no others."""
    errors = []
    for seed in seeds:
        made = simulate_reaches(kind, seed, count=3, placement=seed % 4)
        found = detect(made.recording)
        assert len(found) == 3
        errors += [reach.end_s - end_s for reach, (_, end_s) in zip(found, made.truth, strict=True)]
    return errors


@pytest.mark.parametrize("kind", ["trunk-lean", "drinking", "submovements"])
def test_compensation_by_the_trunk_and_parts_of_a_reach_belong_to_it(kind: str) -> None:
    """The trunk leans in for the arm (Levin et al. 2002, Exp Brain Res 143:171-180); a glass is
    taken, drunk from and put down (Alt Murphy, Willén & Sunnerhagen 2011, Neurorehabil Neural
    Repair 25:71-80); a reach after a stroke has several submovements, with stops (Rohrer et al.
    2002, J Neurosci 22:8297-8304).
    """
    assert abs(float(np.median(ends_of(kind, range(3, 7))))) <= 0.08


def a_reach(excursion_deg: float, lasts_s: float) -> Reach:
    (made,) = detect(
        simulate([ReachShape(out_s=0.6, back_s=0.5, peak_out=2.0, peak_back=-2.4)]).recording
    )
    return msgspec.structs.replace(made, excursion_deg=excursion_deg, reach_time_s=lasts_s)


def test_known_reaches_of_a_person_set_how_small_and_how_long_others_are() -> None:
    person = calibrated([a_reach(60.0, 2.0), a_reach(45.0, 3.0), a_reach(50.0, 2.5)])
    assert person == OrientationParameters(least_rad=np.radians(15.0), longest_s=9.0)
    with pytest.raises(ValueError, match="no reach to calibrate with"):
        calibrated([])

    gesture = WristMotion(12.0, 100.0, np.random.default_rng(7))
    for at_s, turn in ((4.0, 14.0), (5.0, -14.0)):
        gesture.shift(at_s, (turn, 0.0, 0.0), 1.0)
    assert len(detect(gesture.measured())) == 1
    assert detect(gesture.measured(), parameters=person) == ()


def test_a_reach_that_does_not_come_all_the_way_back_is_less_certain() -> None:
    confidence = []
    for back in (40.0, 26.0):
        motion = WristMotion(12.0, 100.0, np.random.default_rng(7))
        motion.shift(4.0, (40.0, 0.0, 0.0), 1.0)
        motion.shift(5.5, (-back, 0.0, 0.0), 1.0)
        (found,) = detect(motion.measured())
        confidence.append(found.confidence)
    assert confidence == pytest.approx([1.0, 0.65], abs=0.05)

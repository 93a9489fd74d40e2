"""Simulated sessions of two: each press, movement, score and feedback has its seat."""

import functools
from contextlib import closing
from pathlib import Path
from statistics import fmean
from typing import Any, NamedTuple

import pytest

from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.inputs.sensor import Imu
from sar_tui.inputs.simulated import SimulatedSource
from sar_tui.loop.bus import Record
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node, on
from sar_tui.loop.session import Session
from sar_tui.loop.task import Task
from sar_tui.loop.topics import (
    ATTEMPT_ENDED,
    CUE,
    KEY,
    PERCEIVED,
    PROPOSED,
    REACH,
    SENSOR,
    STORED,
    TRIAL,
)
from sar_tui.model import messages as m
from sar_tui.model.units import MS
from sar_tui.motion.synthesis import PROFILES, ReachShape, SimulatedHand
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant import SimulatedParticipant, SimulatedPartner
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import connect
from tests.examples import first

POLICIES = ("alternate", "race", "cooperative", "joint attention")
SEEDS = range(10)
KIND, CALM = Catalogue().task("pairs"), Catalogue().theme("calm")

pytestmark = pytest.mark.usefixtures("fewer_blocks")


class Disk(Node):
    """Acknowledges every trial at once."""

    name = "disk"
    emits = (STORED,)

    @on(TRIAL)
    def ended(self, trial: m.TrialEnded) -> None:
        self.emit(STORED, m.Stored(attempt=trial.attempt, trial=trial.trial))


class Played(NamedTuple):
    """Messages of a session."""

    records: tuple[Record, ...]

    def all(self, topic: Any, **wanted: Any) -> list[Any]:
        return [
            record.message
            for record in self.records
            if record.topic is topic
            and all(getattr(record.message, name) == value for name, value in wanted.items())
        ]


def run(task: Task, clock: VirtualClock, seed: int, nodes: list[Node]) -> Played:
    """Run a session to its end."""
    session = Session(task, CALM, clock, seed, [*nodes, Disk()])
    records: list[Record] = []
    session.bus.tap(records.extend)
    session.begin()
    while not session.ended and clock.step():
        pass
    assert session.ended
    assert session.faults == []
    return Played(tuple(records))


@functools.cache
def play(policy: str, seed: int, left: str = "average", right: str = "poor", **more: Any) -> Played:
    """Run a short session of two participants with keys."""
    settings = {"policy": policy, "attempts": 2, "prompts_per_attempt": 6, **more}
    task = KIND(build(KIND.Parameters, settings))
    one = SimulatedParticipant(PEOPLE[left], task, seed)
    other = SimulatedPartner(PEOPLE[right], task, seed, seat="B")
    return run(task, VirtualClock(), seed, [one, other])


def play_reaches(policy: str, seed: int) -> tuple[Played, dict[str, list[int]]]:
    """Run an attempt of three reaches, and return also the times (ns) at which each hand started a
    complete reach, by seat.
    """
    settings = {"policy": policy, "respond_with": "reaches", "attempts": 1}
    settings |= {"prompts_per_attempt": 3, "foreperiod_max_ms": 600, "quiet_ms": 100}
    task, clock = KIND(build(KIND.Parameters, settings)), VirtualClock()
    started: dict[str, list[int]] = {"A": [], "B": []}
    nodes: list[Node] = []
    for number, seat in enumerate("AB"):
        hand = SimulatedSource(SimulatedHand(PROFILES["steady"], 100.0, 2 * seed + number), clock)

        def move(
            at: int, shape: ReachShape, hand: SimulatedSource = hand, seat: str = seat
        ) -> None:
            hand.move(at, shape)
            if shape.out_s > 0.25:  # else a twitch
                started[seat].append(at)

        nodes.append(Imu(ImuFeed(hand, clock.now), seat))
        if seat == "A":
            nodes.append(SimulatedParticipant(PEOPLE["average"], task, seed, move))
        else:
            nodes.append(SimulatedPartner(PEOPLE["poor"], task, seed, move, "B"))
    return run(task, clock, seed, nodes), started


def check_scores_and_feedback(played: Played) -> None:
    """Assert that each result follows from the rows of its seat, and each feedback from the
    result.
    """
    for attempt in played.all(ATTEMPT_ENDED):
        mine = played.all(TRIAL, attempt=attempt.attempt, seat=attempt.seat)
        values = [trial.value for trial in mine if trial.value is not None]
        right = sum(trial.correct for trial in mine)
        assert (attempt.trials, attempt.correct) == (len(mine), right)
        assert attempt.metric == (pytest.approx(fmean(values)) if values else None)
        (answer,) = [
            answer
            for answer in played.all(PROPOSED, kind="feedback", seat=attempt.seat)
            if answer.attempt == attempt.attempt
        ]
        assert answer.valence == attempt.feedback
        side = {"A": "left", "B": "right"}[attempt.seat]
        assert answer.gaze == side
        assert answer.text.startswith(f"{side.capitalize()}: ")


@pytest.mark.parametrize("seed", first(1, SEEDS))
@pytest.mark.parametrize("policy", POLICIES)
def test_each_press_score_and_feedback_has_the_seat_of_its_participant(
    policy: str, seed: int
) -> None:
    played = play(policy, seed)
    owners = {(press.at, press.key): press.seat for press in played.all(PERCEIVED)}
    assert {press.seat for press in played.all(KEY)} == {"A"}  # there is one keyboard
    for trial in played.all(TRIAL):
        assert trial.response is None or owners[trial.response_at, trial.response] == trial.seat
    check_scores_and_feedback(played)


@pytest.mark.parametrize("seed", first(1, SEEDS))
@pytest.mark.parametrize("policy", POLICIES)
def test_each_movement_score_and_feedback_has_the_seat_of_its_participant(
    policy: str, seed: int
) -> None:
    played, started = play_reaches(policy, seed)
    for trial in played.all(TRIAL):
        if trial.response is not None:
            nearest = min(started[trial.seat], key=lambda at: abs(at - trial.response_at))
            assert abs(nearest - trial.response_at) / MS < 30
            assert trial.reaction_time_ms == pytest.approx((trial.response_at - trial.onset) / MS)
    check_scores_and_feedback(played)


def test_the_faster_participant_wins_most_races() -> None:
    won = {"A": 0.0, "B": 0.0}
    for seed in SEEDS:
        for attempt in play("race", seed, left="poor", right="competent").all(ATTEMPT_ENDED):
            won[attempt.seat] += attempt.qualities["won"]
    assert won["B"] > 4 * won["A"]


def test_in_joint_attention_a_look_to_the_other_side_costs_time() -> None:
    times: dict[bool, list[float]] = {True: [], False: []}
    people = {"left": "competent", "right": "competent"}
    for seed in SEEDS:
        played = play("joint attention", seed, prompts_per_attempt=20, **people)
        for cue, trial in zip(played.all(CUE), played.all(TRIAL), strict=True):
            assert (cue.attempt, cue.trial) == (trial.attempt, trial.trial)
            assert cue.side == trial.details["cue"]
            if trial.correct:
                times[trial.details["congruent"]].append(trial.reaction_time_ms)
    assert 0.45 < len(times[True]) / (len(times[True]) + len(times[False])) < 0.55
    assert 10 < fmean(times[False]) - fmean(times[True]) < 50


def test_two_participants_of_the_same_model_perform_differently() -> None:
    played = play("race", 5, right="average")
    left, right = ([row.reaction_time_ms for row in played.all(TRIAL, seat=seat)] for seat in "AB")
    assert left != right


def test_a_session_of_two_with_reaches_is_stored_and_replays_identically(data: Path) -> None:
    given = {"policy": "race", "respond_with": "reaches", "attempts": 1, "prompts_per_attempt": 2}
    catalogue = Catalogue()
    plan = make_plan(catalogue, KIND, ["P01", "P02"], given, seed=3, mode="simulated")
    name = simulate(plan, PEOPLE["average"], data, catalogue, partner=PEOPLE["poor"])
    with closing(connect(data)) as database:
        rows = sessions.rows(database, "trials", name)
        history = list(sessions.history(database, name))
    assert [(row["trial"], row["seat"]) for row in rows] == [(1, "A"), (1, "B"), (2, "A"), (2, "B")]
    assert {record.message.seat for record in history if record.topic is SENSOR} == {"A", "B"}
    assert {record.message.seat for record in history if record.topic is REACH} == {"A", "B"}
    replayed = Session(KIND(plan.parameters), CALM, VirtualClock(), 3)
    replayed.replay(history)
    assert replayed.ended

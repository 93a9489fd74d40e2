"""Simulated sessions of two with keys: seats, scores and feedback of each policy."""

import functools
from typing import Any, NamedTuple

import pytest

from sar_tui.loop.bus import Record
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node, on
from sar_tui.loop.session import Session
from sar_tui.loop.topics import (
    ATTEMPT_ENDED,
    CUE,
    FEEDBACK,
    KEY,
    PERCEIVED,
    PROPOSED,
    STORED,
    TRIAL,
)
from sar_tui.model import messages as m
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build
from sar_tui.simulation.participant import SimulatedParticipant, SimulatedPartner
from sar_tui.simulation.participant_model import PEOPLE
from tests.examples import first

POLICIES = ("alternate", "race", "cooperative", "joint attention")
SEEDS = range(20)
KIND, CALM = Catalogue().task("pairs"), Catalogue().theme("calm")


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
        reported = [record.message for record in self.records if record.topic is topic]
        return [
            one
            for one in reported
            if all(getattr(one, name) == value for name, value in wanted.items())
        ]

    @property
    def proposed_feedback(self) -> list[m.Proposal]:
        return self.all(PROPOSED, kind="feedback")


@functools.cache
def play(policy: str, seed: int, left: str = "average", right: str = "poor", **more: Any) -> Played:
    """Run a short session of two participants."""
    parameters = build(
        KIND.Parameters, {"policy": policy, "attempts": 2, "prompts_per_attempt": 6, **more}
    )
    task, clock = KIND(parameters), VirtualClock()
    two = [
        SimulatedParticipant(PEOPLE[left], task, seed),
        SimulatedPartner(PEOPLE[right], task, seed, seat="B"),
    ]
    session = Session(task, CALM, clock, seed, [*two, Disk()])
    records: list[Record] = []
    session.bus.tap(records.extend)
    session.begin()
    while not session.ended and clock.step():
        pass
    assert session.ended
    assert session.faults == []
    return Played(tuple(records))


@pytest.mark.parametrize("seed", first(4, SEEDS))
@pytest.mark.parametrize("policy", POLICIES)
def test_each_row_and_each_feedback_has_the_seat_of_its_participant(policy: str, seed: int) -> None:
    played = play(policy, seed)
    owners = {(press.at, press.key): press.seat for press in played.all(PERCEIVED)}
    assert {press.seat for press in played.all(KEY)} == {"A"}  # there is one keyboard
    for trial in played.all(TRIAL):
        assert trial.response is None or owners[trial.response_at, trial.response] == trial.seat
    for attempt in played.all(ATTEMPT_ENDED):
        mine = played.all(TRIAL, attempt=attempt.attempt, seat=attempt.seat)
        values = [trial.value for trial in mine if trial.value is not None]
        assert (attempt.trials, attempt.correct) == (
            len(mine),
            sum(trial.correct for trial in mine),
        )
        assert attempt.metric == (pytest.approx(sum(values) / len(values)) if values else None)
    feedback = {(one.attempt, one.seat): one for one in played.proposed_feedback}
    assert set(feedback) == {(one.attempt, one.seat) for one in played.all(ATTEMPT_ENDED)}
    for attempt in played.all(ATTEMPT_ENDED):
        answer = feedback[attempt.attempt, attempt.seat]
        assert answer.valence == attempt.feedback
        assert answer.text.startswith({"A": "Left: ", "B": "Right: "}[attempt.seat])
        assert answer.gaze == {"A": "left", "B": "right"}[attempt.seat]


@pytest.mark.parametrize("seed", first(4, SEEDS))
def test_in_turn_each_does_half_of_the_prompts_and_never_the_others(seed: int) -> None:
    trials = play("alternate", seed).all(TRIAL)
    assert [trial.seat for trial in trials] == list("ABABABBABABA")
    assert all(trial.details["asked"] == trial.stimulus for trial in trials)


@pytest.mark.parametrize("seed", first(4, SEEDS))
def test_in_a_race_the_first_right_response_wins_and_the_answers_follow(seed: int) -> None:
    played = play("race", seed)
    for left, right in zip(played.all(TRIAL, seat="A"), played.all(TRIAL, seat="B"), strict=True):
        assert (left.attempt, left.trial) == (right.attempt, right.trial)
        times = [row.reaction_time_ms for row in (left, right) if row.correct]
        for row in (left, right):
            assert row.details["won"] == (row.correct and row.reaction_time_ms == min(times))
    for left, right in zip(
        played.all(FEEDBACK, seat="A"), played.all(FEEDBACK, seat="B"), strict=True
    ):
        won = [played.all(TRIAL, attempt=left.attempt, seat=seat) for seat in "AB"]
        assert [left.won, right.won] == [sum(row.details["won"] for row in rows) for rows in won]
        ahead = (left.won > right.won) - (left.won < right.won)
        reported = {
            1: ("positive", "negative"),
            0: ("neutral", "neutral"),
            -1: ("negative", "positive"),
        }
        assert (left.valence, right.valence) == reported[ahead]


def test_the_faster_participant_wins_most_races() -> None:
    won = {"A": 0.0, "B": 0.0}
    for seed in SEEDS:
        for attempt in play("race", seed, left="poor", right="competent").all(ATTEMPT_ENDED):
            won[attempt.seat] += attempt.qualities["won"]
    assert won["B"] > 4 * won["A"]


@pytest.mark.parametrize("seed", first(4, SEEDS))
def test_together_both_have_one_result_and_one_outcome(seed: int) -> None:
    played = play("cooperative", seed)
    for left, right in zip(
        played.all(ATTEMPT_ENDED, seat="A"), played.all(ATTEMPT_ENDED, seat="B"), strict=True
    ):
        for name in ("attempt", "metric", "accuracy", "correct", "outcome", "feedback", "level"):
            assert getattr(left, name) == getattr(right, name)
    for left, right in zip(played.all(TRIAL, seat="A"), played.all(TRIAL, seat="B"), strict=True):
        assert (left.correct, left.value) == (right.correct, right.value)
        if left.correct:
            assert abs(left.reaction_time_ms - right.reaction_time_ms) <= 400
            assert left.value == pytest.approx(max(left.reaction_time_ms, right.reaction_time_ms))


def test_in_joint_attention_a_look_to_the_other_side_costs_time() -> None:
    times: dict[bool, list[float]] = {True: [], False: []}
    for seed in SEEDS:
        played = play(
            "joint attention", seed, left="competent", right="competent", prompts_per_attempt=20
        )
        for cue, trial in zip(played.all(CUE), played.all(TRIAL), strict=True):
            assert (cue.attempt, cue.trial, cue.side) == (
                trial.attempt,
                trial.trial,
                trial.details["cue"],
            )
            if trial.correct:
                times[trial.details["congruent"]].append(trial.reaction_time_ms)
    means = {congruent: sum(values) / len(values) for congruent, values in times.items()}
    assert 0.45 < len(times[True]) / (len(times[True]) + len(times[False])) < 0.55
    assert 10 < means[False] - means[True] < 50


@pytest.mark.parametrize("policy", POLICIES)
def test_the_same_seed_gives_the_same_session(policy: str) -> None:
    assert play(policy, 3).records == play.__wrapped__(policy, 3).records


def test_two_participants_of_the_same_model_perform_differently() -> None:
    played = play("race", 5, right="average")
    left, right = ([row.reaction_time_ms for row in played.all(TRIAL, seat=seat)] for seat in "AB")
    assert left != right

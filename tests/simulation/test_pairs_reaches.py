"""Simulated sessions of two with reaches: seats, scores and feedback of each policy."""

from pathlib import Path
from typing import Any, NamedTuple

import pytest

from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.inputs.sensor import Imu
from sar_tui.inputs.simulated import SimulatedSource
from sar_tui.loop.bus import Record
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node
from sar_tui.loop.session import Session
from sar_tui.loop.topics import ATTEMPT_ENDED, PROPOSED, REACH, SENSOR, TRIAL
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
from tests.simulation.test_pairs import CALM, KIND, POLICIES, Disk, Played

SEEDS = range(10)
MAX_ONSET_ERROR_MS = 30
"""Largest error of a detected movement onset."""


@pytest.fixture(autouse=True)
def samples_in_fewer_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Feed larger blocks: the result is the same, and making many small blocks takes time."""
    monkeypatch.setattr("sar_tui.inputs.simulated.STEP", 80 * MS)
    monkeypatch.setattr("sar_tui.inputs.sensor.DRAIN", 80 * MS)


class PlayedReaches(NamedTuple):
    """Messages of a session, and the times (ns) at which each hand started a complete reach, by
    seat.
    """

    played: Played
    onsets: dict[str, list[int]]


def play(policy: str, seed: int) -> PlayedReaches:
    """Run a session of one attempt of three prompts, with sensors of 100 Hz."""
    given = {"policy": policy, "respond_with": "reaches", "attempts": 1, "prompts_per_attempt": 3}
    given |= {"foreperiod_max_ms": 600, "quiet_ms": 100}
    task, clock = KIND(build(KIND.Parameters, given)), VirtualClock()
    onsets: dict[str, list[int]] = {"A": [], "B": []}
    nodes: list[Node] = [Disk()]
    for number, seat in enumerate("AB"):
        hand = SimulatedSource(SimulatedHand(PROFILES["steady"], 100.0, 2 * seed + number), clock)

        def move(
            at: int, shape: ReachShape, hand: SimulatedSource = hand, seat: str = seat
        ) -> None:
            hand.move(at, shape)
            if shape.out_s > 0.25:  # else a twitch
                onsets[seat].append(at)

        nodes.append(Imu(ImuFeed(hand, clock.now), seat))
        if seat == "A":
            nodes.append(SimulatedParticipant(PEOPLE["average"], task, seed, move))
        else:
            nodes.append(SimulatedPartner(PEOPLE["poor"], task, seed, move, "B"))
    session = Session(task, CALM, clock, seed, nodes)
    records: list[Record] = []
    session.bus.tap(records.extend)
    session.begin()
    while not session.ended and clock.step():
        pass
    assert session.faults == []
    return PlayedReaches(Played(tuple(records)), onsets)


@pytest.mark.parametrize("policy", POLICIES)
@pytest.mark.parametrize("seed", first(1, SEEDS))
def test_each_movement_and_each_feedback_has_the_seat_of_its_participant(
    policy: str, seed: int
) -> None:
    played, onsets = play(policy, seed)
    trials = played.all(TRIAL)
    for trial in trials:
        if trial.response is not None:
            nearest = min(onsets[trial.seat], key=lambda at: abs(at - trial.response_at))
            assert abs(nearest - trial.response_at) / MS < MAX_ONSET_ERROR_MS
            assert trial.reaction_time_ms == pytest.approx((trial.response_at - trial.onset) / MS)
    seats = [{trial.seat for trial in trials if trial.trial == number} for number in (1, 2, 3)]
    if policy == "alternate":
        assert seats == [{"A"}, {"B"}, {"A"}]
    elif policy == "joint attention":
        assert [len(one) for one in seats] == [1, 1, 1]
    else:
        assert seats == [{"A", "B"}] * 3
    for number in (1, 2, 3):
        rows = [trial for trial in trials if trial.trial == number]
        _check_results(policy, rows)
    for ended in played.all(ATTEMPT_ENDED):
        mine = [trial for trial in trials if trial.seat == ended.seat]
        values = [trial.value for trial in mine if trial.value is not None]
        assert ended.metric == (pytest.approx(sum(values) / len(values)) if values else None)
        (answer,) = [one for one in played.all(PROPOSED, kind="feedback") if one.seat == ended.seat]
        assert answer.valence == ended.feedback
        assert answer.text.startswith({"A": "Left: ", "B": "Right: "}[ended.seat])


def _check_results(policy: str, rows: list[Any]) -> None:
    """Check the results of the trials of a prompt against the policy."""
    times = [row.reaction_time_ms for row in rows if row.details["right"]]
    for row in rows:
        match policy:
            case "race":
                assert row.details["won"] == (row.correct and row.reaction_time_ms == min(times))
            case "cooperative":
                together = len(times) == 2 and abs(times[0] - times[1]) <= 400
                assert (row.correct, row.value) == (together, max(times) if together else None)
            case _:
                assert (row.correct, row.value) == (row.details["right"], row.reaction_time_ms)


def test_a_session_of_two_with_reaches_is_stored_and_replays_identically(data: Path) -> None:
    given = {"policy": "race", "respond_with": "reaches", "attempts": 1, "prompts_per_attempt": 2}
    catalogue = Catalogue()
    plan = make_plan(catalogue, KIND, ["P01", "P02"], given, seed=3, mode="simulated")
    name = simulate(plan, PEOPLE["average"], data, catalogue, partner=PEOPLE["poor"])
    database = connect(data)
    rows = sessions.rows(database, "trials", name)
    history = list(sessions.history(database, name))
    database.close()
    assert [(row["trial"], row["seat"]) for row in rows] == [(1, "A"), (1, "B"), (2, "A"), (2, "B")]
    assert {row["stimulus"] for row in rows} == {"reach"}
    assert {record.message.seat for record in history if record.topic is SENSOR} == {"A", "B"}
    assert {record.message.seat for record in history if record.topic is REACH} == {"A", "B"}
    replayed = Session(KIND(plan.parameters), CALM, VirtualClock(), 3)
    replayed.replay(history)
    assert replayed.ended

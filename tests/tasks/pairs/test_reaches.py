"""Pair policies with reaches: the movement onsets of both seats decide."""

from typing import Any

import pytest

from sar_tui.loop.task import Task
from sar_tui.loop.topics import ATTEMPT_ENDED, FEEDBACK, PROMPT, REACH, TRIAL, VOIDED, WAITING
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build
from tests.tasks.pairs.pairs_driver import SLOW, TWITCH, PairsReachingDriver

NEAR = 30
"""Within so many ms of the truth the detector finds the onset of a clean movement."""
KIND: Any = Catalogue().task("pairs")


pytestmark = pytest.mark.usefixtures("fewer_blocks")


def make(**parameters: Any) -> Task:
    task: Task = KIND(build(KIND.Parameters, parameters))
    return task


def near(ms: float) -> Any:
    return pytest.approx(ms, abs=NEAR)


# --- the four policies


def test_in_turn_the_onset_of_the_reach_is_the_response() -> None:
    driver = PairsReachingDriver("alternate")
    assert driver.start_session().seat == "A"
    (left,) = driver.reach(("A", 400)).values()
    assert (left.seat, left.correct, left.stimulus, left.response) == ("A", True, "reach", "reach")
    assert left.reaction_time_ms == left.value == near(400)
    assert ((left.response_at or 0) - (left.onset or 0)) / 1e6 == pytest.approx(left.value)
    assert left.details["reach_time_ms"] == near(1000)
    assert (left.response_at or 0) < left.details["turn_ns"] < left.details["movement_end_ns"]
    assert set(left.details) <= set(KIND.Details.__struct_fields__)
    (right,) = driver.reach(("B", 700)).values()
    assert (right.seat, right.correct, right.reaction_time_ms) == ("B", True, near(700))
    assert right.timing.flags == ()
    metrics = {one.seat: one.metric for one in driver.all(ATTEMPT_ENDED)}
    assert metrics == {"A": near(400), "B": near(700)}


def test_in_turn_a_reach_of_the_other_seat_is_only_flagged() -> None:
    driver = PairsReachingDriver("alternate", response_timeout_ms=6000)
    driver.start_session()
    rows = driver.reach(("B", 300), ("A", 1500))
    assert set(rows) == {"A"}
    assert (rows["A"].correct, rows["A"].reaction_time_ms) == (True, near(1500))
    assert rows["A"].timing.flags == ("other_seat",)


def test_in_a_race_the_first_onset_wins_even_if_the_other_returns_first() -> None:
    driver = PairsReachingDriver("race", response_timeout_ms=6000)
    driver.start_session()
    rows = driver.reach(("A", 700), ("B", 500, SLOW))
    assert rows["A"].details["movement_end_ns"] < rows["B"].details["movement_end_ns"]
    assert (rows["A"].details["won"], rows["B"].details["won"]) == (False, True)
    assert (rows["A"].reaction_time_ms, rows["B"].reaction_time_ms) == (near(700), near(500))
    assert sorted(reach.seat for reach in driver.all(REACH)) == ["A", "B"], "each once"
    rows = driver.reach(("A", 400, TWITCH), ("B", 600))
    assert rows["A"].correct is rows["A"].details["won"] is False
    assert rows["B"].details["won"] is True
    by_seat = {one.seat: (one.won, one.valence) for one in driver.all(FEEDBACK)}
    assert by_seat == {"A": (0, "negative"), "B": (2, "positive")}


# --- what is no response


def test_a_missing_reach_is_a_miss_with_an_instruction() -> None:
    driver = PairsReachingDriver("alternate", prompts_per_attempt=2, attempts=1)
    driver.start_session()
    (row,) = driver.reach().values()
    assert (row.seat, row.response, row.correct) == ("A", None, False)
    assert row.timing.flags == ("no_reach",)
    driver.reach(("B", 500))
    assert {one.seat: bool(one.remark) for one in driver.all(FEEDBACK)} == {"A": True, "B": False}


def test_keys_are_no_response_in_a_session_of_reaches() -> None:
    driver = PairsReachingDriver("alternate")
    driver.start_session()
    for key in ("f", "j", "space"):
        driver.press(key)
    assert driver.all(TRIAL) == []
    (row,) = driver.reach(("A", 400)).values()
    assert (row.response, row.timing.flags) == ("reach", ())


def test_a_reach_that_a_sensor_missed_is_repeated_by_both() -> None:
    driver = PairsReachingDriver("race")
    driver.start_session()
    onset = driver.clock.now()
    for seat, hand in driver.hands.items():
        hand.move(onset + 500_000_000, SLOW)
        sink = hand._sink
        lost = (onset + 900_000_000, onset + 1_300_000_000) if seat == "B" else (0, 0)
        hand._sink = lambda sample, sink=sink, lost=lost: (
            None if lost[0] < sample.host_ns < lost[1] else sink(sample)
        )
    driver.wait(5000)
    assert [voided.reason for voided in driver.all(VOIDED)] == ["gap"]
    rows = driver.reach(("A", 500), ("B", 600))
    again = [(row.trial, row.correct, row.timing.presentation) for row in rows.values()]
    assert again == [(1, True, 2)] * 2


# --- the sensors


def test_a_detached_sensor_pauses_the_session_and_its_seat_is_named() -> None:
    driver = PairsReachingDriver("alternate")
    driver.start_session()
    changes = (
        ("B", "detached", "Unplugged.", "B"),
        ("A", "stalled", "", ""),  # of both
        ("B", "attached", "", "A"),
    )
    for seat, state, detail, named in changes:
        driver.sensor(seat, state, detail)
        waiting = driver.last(WAITING)
        assert (waiting.what, waiting.stage, waiting.seat) == ("sensor", "paused", named)
        assert seat != "B" or waiting.detail == detail
    driver.sensor("A", "flowing")
    (row,) = driver.reach(("A", 400)).values()
    assert (row.seat, row.trial, row.correct, row.timing.presentation) == ("A", 1, True, 2)


def test_a_session_of_keys_has_no_sensor() -> None:
    keys, hands = make(), make(respond_with="reaches")
    assert (keys.sensor_seats(keys.parameters), keys.nodes()) == ((), ())
    assert hands.sensor_seats(hands.parameters) == ("A", "B")
    assert [node.name for node in hands.nodes()] == ["reach_perception", "reach_perception_b"]


# --- prompts, levels, words


def test_go_is_shown_in_the_half_of_the_prompted_seat() -> None:
    driver = PairsReachingDriver("alternate")
    driver.start_session()
    driver.reach(("A", 400))
    driver.to_prompt()
    shown = [(prompt.halves, prompt.text.split(":")[0]) for prompt in driver.all(PROMPT)]
    assert shown == [(("GO", ""), "Left"), (("", "GO"), "Right")]


def test_each_level_has_an_earlier_goal() -> None:
    task = make(respond_with="reaches", threshold=800)
    goals = [task.target(level).threshold for level in range(1, task.levels + 1)]
    assert goals == [800, 720, 640, 560, 480, 400]
    assert {make(threshold=800).target(level).threshold for level in range(1, 7)} == {800}

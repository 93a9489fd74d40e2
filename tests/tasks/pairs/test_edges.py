"""Edge cases of the pair policies with keys."""

from collections.abc import Callable
from typing import Any

import pytest

from sar_tui.loop.task import Task
from sar_tui.loop.topics import CUE, FEEDBACK, TRIAL
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Performance, Result, Situation, Stimulus
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build
from tests.tasks.pairs.pairs_driver import SHORT, PairsDriver

NewSession = Callable[..., PairsDriver]


@pytest.fixture
def pairs(catalogue: Catalogue) -> type[Task]:
    return catalogue.task("pairs")


@pytest.fixture
def new_session(pairs: type[Task], calm: Theme) -> NewSession:
    def open_session(policy: str, **parameters: Any) -> PairsDriver:
        driver = PairsDriver(pairs, calm, policy=policy, **(SHORT | parameters))
        driver.start()
        return driver

    return open_session


def test_together_an_anticipation_is_no_response_however_close_to_the_other(
    new_session: NewSession,
) -> None:
    rows = new_session("cooperative", window_ms=300).both(a_ms=80, b_ms=200)
    assert [(rows[seat].correct, rows[seat].details["together"]) for seat in "AB"] == [
        (False, False)
    ] * 2
    assert ["anticipation" in rows[seat].timing.flags for seat in "AB"] == [True, False]


def test_together_both_miss_if_nobody_responds(new_session: NewSession) -> None:
    driver = new_session("cooperative", response_timeout_ms=500)
    driver.to_prompt()
    driver.wait(600)
    rows = driver.by_seat(driver.all(TRIAL))
    assert [(rows[seat].response, rows[seat].correct, rows[seat].value) for seat in "AB"] == [
        (None, False, None)
    ] * 2


def test_a_correct_key_counts_with_caps_lock_on(new_session: NewSession) -> None:
    driver = new_session("race")
    left, right = driver.keys
    rows = driver.by_seat(driver.press_after((300, left.upper()), (400, right)))
    assert (rows["A"].correct, rows["A"].details["won"], rows["A"].response) == (
        True,
        True,
        left.upper(),
    )


def test_the_time_since_the_last_key_is_stored_per_seat_in_milliseconds(
    new_session: NewSession,
) -> None:
    driver = new_session("race")
    first = driver.both(300, 350)
    second = driver.both(310, 400)
    since = (second["A"].response_at or 0) - (first["A"].response_at or 0)
    assert second["A"].details["key_gap_ms"] == pytest.approx(since / 1_000_000)
    assert first["B"].details["key_gap_ms"] is None


def test_each_row_of_a_race_has_the_delay_of_its_seats_key(new_session: NewSession) -> None:
    driver = new_session("race")
    left, right = driver.keys
    now = driver.clock.now()
    driver.wait(400)
    driver.press(left, at=now + 300_000_000)
    driver.press(right, at=now + 350_000_000)
    rows = driver.by_seat(driver.all(TRIAL))
    assert [rows[seat].timing.handler_delay_ms for seat in "AB"] == pytest.approx([100, 50])


def test_a_slow_response_without_result_is_excluded_from_the_cueing_effect(
    pairs: type[Task],
) -> None:
    task = pairs(build(pairs.Parameters, {"policy": "joint attention"}))
    results = [
        Result(correct=True, value=300.0, details={"congruent": True}),
        Result(correct=True, value=340.0, details={"congruent": False}),
        Result(correct=False, value=900.0, details={"congruent": False}),
        Result(correct=True, value=20.0, details={"congruent": True}, flags=("anticipation",)),
    ]
    assert task.measures(results) == {"congruency_effect_ms": 40.0}


def test_the_order_of_sides_differs_between_attempts(pairs: type[Task]) -> None:
    task = pairs(build(pairs.Parameters, {"policy": "joint attention", "prompts_per_attempt": 20}))

    def sides(attempt: int) -> list[str]:
        at = [
            Situation(attempt, trial, 1, RandomStreams(3, attempt, trial), RandomStreams(3))
            for trial in range(1, 21)
        ]
        return [task.stimulus(situation).seat for situation in at]

    assert len({tuple(sides(attempt)) for attempt in range(1, 6)}) == 5
    assert all(sorted(sides(attempt)) == ["A"] * 10 + ["B"] * 10 for attempt in range(1, 6))


def test_a_key_before_the_cue_delays_the_cue_which_is_given_once(new_session: NewSession) -> None:
    driver = new_session(
        "joint attention", cue_lead_ms=400, foreperiod_min_ms=1500, foreperiod_max_ms=1600
    )
    driver.press_after((300, "".join(driver.keys)))
    known = len(driver.all(CUE))
    driver.until(lambda: driver.waiting.what == "foreperiod")
    driver.wait(900)
    driver.press("space")
    driver.wait(490)
    assert len(driver.all(CUE)) == known
    driver.to_prompt()
    assert len(driver.all(CUE)) == known + 1


def test_a_second_key_does_not_change_the_row_of_the_first(new_session: NewSession) -> None:
    driver = new_session("race")
    left, right = driver.keys
    driver.wait(300)
    driver.press(left)
    driver.wait(200)
    driver.press("d" if left != "d" else "s", at=driver.clock.now() - 50_000_000)
    driver.press(right)
    rows = driver.by_seat(driver.all(TRIAL))
    assert [rows[seat].timing.handler_delay_ms for seat in "AB"] == [0, 0]


@pytest.mark.parametrize("policy", ["alternate", "cooperative", "joint attention"])
def test_wins_are_mentioned_only_in_a_race(new_session: NewSession, policy: str) -> None:
    driver = new_session(policy)
    for _ in range(2):
        left, right = driver.keys
        driver.press_after(*((300, key) for key in (left, right) if key))
    assert [answer.won for answer in driver.all(FEEDBACK)] == [None, None]


@pytest.mark.parametrize("seat", ["A", "B"])
def test_a_simulated_slip_is_another_key_of_the_same_half(pairs: type[Task], seat: str) -> None:
    task = pairs(build(pairs.Parameters, {"policy": "race"}))
    stimulus = Stimulus("f j", "", "", seat=seat, halves=("f", "j"))
    for seed in range(50):
        ((_, key),) = task.rehearse(stimulus, Performance(400, slips=True), RandomStreams(seed))
        assert key != stimulus.halves["AB".index(seat)]
        assert task.seat_of(key) == seat


def test_feedback_on_a_race_says_plainly_who_won(new_session: NewSession) -> None:
    driver = new_session("race", threshold=5000)
    for _ in range(2):
        driver.both(300, 350)
    assert [(answer.reason, answer.choice.degree) for answer in driver.all(FEEDBACK)] == [
        ("won", "clear"),
        ("lost", "clear"),
    ]

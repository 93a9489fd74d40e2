"""Pair policies with keys: rows, scores and feedback per seat."""

from collections.abc import Callable
from typing import Any

import pytest

from sar_tui.loop.task import Task
from sar_tui.loop.topics import (
    ATTEMPT_ENDED,
    CUE,
    FEEDBACK,
    LEVEL,
    PERCEIVED,
    PROMPT,
    PROPOSED,
    TRIAL,
    WAITING,
)
from sar_tui.model.messages import TrialEnded
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Performance, Result, Situation, Stimulus
from sar_tui.plugins import Catalogue
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.parameters import build
from tests.tasks.pairs.pairs_driver import SHORT, PairsDriver

NewSession = Callable[..., PairsDriver]


@pytest.fixture(scope="session")
def pairs(catalogue: Catalogue) -> type[Task]:
    return catalogue.task("pairs")


@pytest.fixture
def new_session(pairs: type[Task], calm: Theme) -> NewSession:
    def open_session(policy: str, start: bool = True, **parameters: Any) -> PairsDriver:
        driver = PairsDriver(pairs, calm, policy=policy, **(SHORT | parameters))
        if start:
            driver.start()
        return driver

    return open_session


def told(rows: dict[str, TrialEnded], *names: str) -> list[tuple[Any, ...]]:
    """Return columns or details of both seats' rows; times in whole ms."""
    return [tuple(_field(rows[seat], name) for name in names) for seat in "AB"]


def _field(row: TrialEnded, name: str) -> Any:
    value = row.details[name] if name in row.details else getattr(row, name)
    return round(value) if isinstance(value, float) else value


def ended(driver: PairsDriver) -> list[Any]:
    """Return the results of the first attempt, A's first."""
    driver.wait(1000)
    return sorted(
        (one for one in driver.all(ATTEMPT_ENDED) if one.attempt == 1), key=lambda one: one.seat
    )


def wrong(key: str) -> str:
    """Return another key of the left half."""
    return "x" if key != "x" else "z"


# --- alternate


def test_in_turn_seats_alternate_and_so_does_the_first_seat(new_session: NewSession) -> None:
    driver = new_session("alternate", prompts_per_attempt=3)
    for _ in range(2):
        for _ in range(3):
            driver.press_after((300, "".join(driver.keys)))
        driver.wait(1000)
        driver.press("enter")
    rows = driver.all(TRIAL)
    assert "".join(f"{row.attempt}{row.seat} " for row in rows) == "1A 1B 1A 2B 2A 2B "
    assert all(row.correct and round(row.reaction_time_ms or 0) == 300 for row in rows)
    assert [prompt.seat for prompt in driver.all(PROMPT)] == [row.seat for row in rows]


@pytest.mark.parametrize(
    ("keys", "flags"), [(("j", "k"), ("other_seat",)), (("space", "enter", "left"), ())]
)
def test_in_turn_keys_of_the_other_seat_are_flagged_and_of_neither_half_ignored(
    new_session: NewSession, keys: tuple[str, ...], flags: tuple[str, ...]
) -> None:
    driver = new_session("alternate")
    left, _ = driver.keys
    assert driver.press_after(*((200.0 + 20 * index, key) for index, key in enumerate(keys))) == []
    (row,) = driver.press_after((100, left))
    assert (row.seat, row.correct, row.response, row.timing.flags) == ("A", True, left, flags)


def test_in_turn_the_turn_is_announced_before_the_prompt(new_session: NewSession) -> None:
    driver = new_session("alternate")
    assert {waiting.seat for waiting in driver.all(WAITING) if waiting.stage == "trial"} == {"A"}
    assert {waiting.seat for waiting in driver.all(WAITING) if waiting.stage != "trial"} == {""}
    driver.press_after((300, "".join(driver.keys)))
    driver.to_prompt()
    assert driver.waiting.seat == "B"


def test_in_turn_each_seat_has_its_score_and_feedback_and_the_level_is_shared(
    new_session: NewSession,
) -> None:
    driver = new_session("alternate", prompts_per_attempt=4)
    for _ in range(4):
        left, right = driver.keys
        driver.press_after((400, left) if left else (1300, right))
    assert [
        (one.outcome, one.feedback, round(one.metric), one.trials) for one in ended(driver)
    ] == [("success", "positive", 400, 2), ("failure", "negative", 1300, 2)]
    assert driver.all(LEVEL) == []
    given = [(one.seat, one.valence, one.won) for one in driver.all(FEEDBACK)]
    assert given == [("A", "positive", None), ("B", "negative", None)]


# --- race


@pytest.mark.parametrize(
    ("a_ms", "b_ms", "won"),
    [(500, 400, (False, True)), (400, 400, (True, True)), (50, 400, (False, True))],
)
def test_in_a_race_the_fastest_response_that_is_no_anticipation_wins(
    new_session: NewSession, a_ms: int, b_ms: int, won: tuple[bool, bool]
) -> None:
    rows = new_session("race").both(a_ms=a_ms, b_ms=b_ms)
    early = a_ms < 100
    assert told(rows, "won", "value") == [(won[0], None if early else a_ms), (won[1], b_ms)]
    assert rows["A"].timing.flags == (("anticipation",) if early else ())


@pytest.mark.parametrize("corrects", [False, True])
def test_in_a_race_a_slow_right_key_wins_over_a_fast_wrong_one_corrected_or_not(
    new_session: NewSession, corrects: bool
) -> None:
    driver = new_session("race")
    left, right = driver.keys
    presses = [(300.0, wrong(left)), (900.0, right), *([(350.0, left)] if corrects else [])]
    rows = driver.by_seat(driver.press_after(*presses))
    assert told(rows, "correct", "won", "response") == [
        (False, False, wrong(left)),
        (True, True, right),
    ]


def test_in_a_race_the_other_seat_wins_after_a_miss(new_session: NewSession) -> None:
    driver = new_session("race", response_timeout_ms=1000)
    left, _ = driver.keys
    assert driver.press_after((300, left)) == []
    driver.wait(1000)
    assert told(driver.by_seat(driver.all(TRIAL)), "response", "correct", "won", "value") == [
        (left, True, True, 300),
        (None, False, False, None),
    ]


@pytest.mark.parametrize(
    ("a_ms", "b_ms", "valences", "won"),
    [
        ((400, 400), (500, 500), ("positive", "negative"), (2, 0)),
        ((500, 1500), (400, 1400), ("negative", "positive"), (0, 2)),
        ((400, 600), (500, 500), ("neutral", "neutral"), (1, 1)),
    ],
)
def test_feedback_on_a_race_depends_on_winning_not_on_the_goal(
    new_session: NewSession,
    a_ms: tuple[int, int],
    b_ms: tuple[int, int],
    valences: tuple[str, str],
    won: tuple[int, int],
) -> None:
    driver = new_session("race", feedback_form="quantitative")
    for a, b in zip(a_ms, b_ms, strict=True):
        driver.both(a, b)
    assert [one.qualities["won"] for one in ended(driver)] == list(won)
    answers = {one.seat: one for one in driver.all(PROPOSED) if one.kind == "feedback"}
    assert (answers["A"].valence, answers["B"].valence) == valences
    assert all(f"{won[i]} of 2" in answers[seat].text for i, seat in enumerate("AB"))
    assert [feedback.won for feedback in driver.all(FEEDBACK)] == list(won)


def test_the_level_of_a_race_rises_if_both_reach_the_goal_whoever_won(
    new_session: NewSession,
) -> None:
    driver = new_session("race")
    for _ in range(2):
        driver.both(400, 500)
    assert [one.outcome for one in ended(driver)] == ["success", "success"]
    assert [(change.previous, change.level) for change in driver.all(LEVEL)] == [(1, 2)]
    assert driver.waiting.level == 2


def test_feedback_on_a_race_says_plainly_who_won_and_without_a_winner_the_accuracy(
    new_session: NewSession,
) -> None:
    driver = new_session("race", threshold=5000)
    for _ in range(2):
        driver.both(300, 350)
    given = [(answer.reason, answer.choice.degree) for answer in driver.all(FEEDBACK)]
    assert given == [("won", "clear"), ("lost", "clear")]
    nobody = new_session("race", response_timeout_ms=500)
    for _ in range(2):
        nobody.to_prompt()
        nobody.wait(600)
    nobody.wait(1000)
    assert {feedback.reason for feedback in nobody.all(FEEDBACK)} == {"accuracy"}


def test_a_skipped_prompt_of_a_race_has_no_winner(new_session: NewSession) -> None:
    driver = new_session("race")
    driver.operate("skip")
    skipped = [(row.seat, row.correct, row.timing.flags) for row in driver.all(TRIAL)]
    assert skipped == [("A", False, ("skipped",)), ("B", False, ("skipped",))]
    driver.both(400, 500)
    assert [one.qualities["won"] for one in ended(driver)] == [1, 0]


# --- cooperative


@pytest.mark.parametrize(
    ("b_ms", "together"), [(650, True), (700, True), (701, False), (100, True), (90, False)]
)
def test_together_is_correct_only_if_both_are_correct_within_the_window(
    new_session: NewSession, b_ms: int, together: bool
) -> None:
    rows = new_session("cooperative", window_ms=300).both(a_ms=400, b_ms=b_ms)
    assert (
        told(rows, "correct", "together", "right", "between_ms", "value")
        == [(together, together, True, abs(b_ms - 400), max(400, b_ms) if together else None)] * 2
    )


def test_together_an_anticipation_is_no_response_however_close_to_the_other(
    new_session: NewSession,
) -> None:
    rows = new_session("cooperative", window_ms=300).both(a_ms=80, b_ms=200)
    assert told(rows, "correct", "together") == [(False, False)] * 2
    assert ["anticipation" in rows[seat].timing.flags for seat in "AB"] == [True, False]


def test_together_one_wrong_key_fails_both(new_session: NewSession) -> None:
    driver = new_session("cooperative")
    left, right = driver.keys
    rows = driver.by_seat(driver.press_after((400, left), (450, "m" if right != "m" else "n")))
    assert told(rows, "correct", "right") == [(False, True), (False, False)]


def test_together_both_have_one_result_and_one_outcome(new_session: NewSession) -> None:
    driver = new_session("cooperative")
    driver.both(300, 500)
    driver.both(600, 400)
    results = {
        (round(one.metric), one.accuracy, one.outcome, one.feedback) for one in ended(driver)
    }
    assert results == {(550, 1.0, "success", "positive")}
    assert {one.valence for one in driver.all(PROPOSED) if one.kind == "feedback"} == {"positive"}


@pytest.mark.parametrize("responds", [False, True])
def test_together_one_response_alone_or_none_is_not_correct(
    new_session: NewSession, responds: bool
) -> None:
    driver = new_session("cooperative", response_timeout_ms=800)
    left, _ = driver.keys
    driver.press_after(*([(300.0, left)] if responds else []))
    driver.wait(900)
    assert told(driver.by_seat(driver.all(TRIAL)), "correct", "right", "between_ms", "value") == [
        (False, responds, None, None),
        (False, False, None, None),
    ]


# --- joint attention


def test_the_agent_looks_to_a_side_before_the_prompt_and_the_lead_is_measured(
    new_session: NewSession,
) -> None:
    driver = new_session("joint attention", cue_lead_ms=300)
    (row,) = driver.press_after((350, "".join(driver.keys)))
    (cue,) = driver.all(CUE)
    shown, given = (
        next(record.at for record in driver.records if record.topic is topic)
        for topic in (PROMPT, CUE)
    )
    assert shown - given == 300_000_000
    assert row.details["cue_lead_ms"] == pytest.approx(304)  # and the screen took 4 ms
    assert (cue.side, cue.gaze, cue.gesture) == (row.details["cue"], cue.side, "")
    assert row.details["congruent"] == (cue.side == ("left" if row.seat == "A" else "right"))


@pytest.mark.parametrize("cue_by", ["gaze", "gesture", "both"])
def test_the_cue_is_gaze_gesture_or_both_and_alone_announces_the_side(
    new_session: NewSession, cue_by: str
) -> None:
    driver = new_session("joint attention", cue_by=cue_by)
    cue = driver.last(CUE)
    assert cue.gaze == (cue.side if cue_by != "gesture" else "")
    assert cue.gesture == (f"point_{cue.side}" if cue_by != "gaze" else "")
    assert {waiting.seat for waiting in driver.all(WAITING)} == {""}
    assert driver.last(PROMPT).seat in ("A", "B")


def test_in_joint_attention_only_keys_on_the_side_of_the_prompt_count(
    new_session: NewSession,
) -> None:
    driver = new_session("joint attention")
    left, right = driver.keys
    assert driver.press_after((200, "k" if left else "d")) == []
    (row,) = driver.press_after((100, left or right))
    assert (row.seat, row.correct) == ("A" if left else "B", True)
    assert "other_seat" in row.timing.flags


@pytest.mark.parametrize("share", [1.0, 0.0])
def test_the_share_of_congruent_trials_is_as_set_and_sides_are_balanced(
    new_session: NewSession, share: float
) -> None:
    driver = new_session("joint attention", congruent_share=share, prompts_per_attempt=10)
    for _ in range(10):
        driver.press_after((300, "".join(driver.keys)))
    assert {row.details["congruent"] for row in driver.all(TRIAL)} == {bool(share)}
    assert [row.seat for row in driver.all(TRIAL)].count("A") == 5


def test_the_order_of_sides_differs_between_attempts(pairs: type[Task]) -> None:
    task = pairs(build(pairs.Parameters, {"policy": "joint attention", "prompts_per_attempt": 20}))
    sides = {
        "".join(
            task.stimulus(Situation(a, t, 1, RandomStreams(3, a, t), RandomStreams(3))).seat
            for t in range(1, 21)
        )
        for a in range(1, 6)
    }
    assert len(sides) == 5
    assert all(order.count("A") == 10 for order in sides)


def test_a_key_after_the_cue_restarts_the_foreperiod_with_a_new_cue(
    new_session: NewSession,
) -> None:
    driver = new_session("joint attention", start=False)
    driver.enter()
    driver.press("enter")
    driver.until(lambda: driver.all(CUE))
    driver.press("f")
    driver.to_prompt()
    assert len(driver.all(CUE)) == 2
    (row,) = driver.press_after((300, "".join(driver.keys)))
    assert row.details["cue_lead_ms"] == pytest.approx(404)
    assert row.timing.false_starts == 1


def test_a_key_before_the_cue_delays_the_cue_which_is_given_once(new_session: NewSession) -> None:
    waits = {"cue_lead_ms": 400, "foreperiod_min_ms": 1500, "foreperiod_max_ms": 1600}
    driver = new_session("joint attention", **waits)
    driver.press_after((300, "".join(driver.keys)))
    known = len(driver.all(CUE))
    driver.until(lambda: driver.waiting.what == "foreperiod")
    driver.wait(900)
    driver.press("space")
    driver.wait(490)
    assert len(driver.all(CUE)) == known
    driver.to_prompt()
    assert len(driver.all(CUE)) == known + 1


def test_the_cueing_effect_is_incongruent_minus_congruent(new_session: NewSession) -> None:
    driver = new_session("joint attention", prompts_per_attempt=20)
    for _ in range(20):
        left, right = driver.keys
        looked = driver.last(CUE).side == ("left" if left else "right")
        driver.press_after((300 if looked else 340, left or right))
    for one in ended(driver):
        assert one.qualities["congruency_effect_ms"] == pytest.approx(40, abs=0.1)


def test_wrong_and_early_responses_are_excluded_from_the_cueing_effect(pairs: type[Task]) -> None:
    task = pairs(build(pairs.Parameters, {"policy": "joint attention"}))
    results = [
        Result(correct=True, value=300.0, details={"congruent": True}),
        Result(correct=True, value=340.0, details={"congruent": False}),
        Result(correct=False, value=900.0, details={"congruent": False}),
        Result(correct=True, value=20.0, details={"congruent": True}, flags=("anticipation",)),
    ]
    assert task.measures(results) == {"congruency_effect_ms": 40.0}


def test_a_lead_longer_than_the_shortest_foreperiod_is_refused(pairs: type[Task]) -> None:
    with pytest.raises(ParameterError, match=r"Cue lead \(900 ms\) is longer than"):
        build(pairs.Parameters, {"policy": "joint attention", "cue_lead_ms": 900})


# --- perception


def test_presses_repeats_and_gaps_are_counted_per_seat(new_session: NewSession) -> None:
    driver = new_session("race", start=False)
    for at, key in ((0, "f"), (10, "j"), (30, "f"), (45, "j"), (50, "space"), (200, "f")):
        driver.press(key, at=driver.clock.now() + at * 1_000_000)
    assert [
        (one.seat, one.key, one.repeat, one.gap and one.gap // 1_000_000)
        for one in driver.all(PERCEIVED)
    ] == [
        ("A", "f", False, None), ("B", "j", False, None), ("A", "f", True, 30),
        ("B", "j", True, 35), ("", "space", False, None), ("A", "f", False, 170),
    ]  # fmt: skip


def test_a_correct_key_counts_with_caps_lock_on(new_session: NewSession) -> None:
    driver = new_session("race")
    left, right = driver.keys
    rows = driver.by_seat(driver.press_after((300, left.upper()), (400, right)))
    assert told(rows, "correct", "won", "response")[0] == (True, True, left.upper())


def test_the_time_since_the_last_key_is_stored_per_seat_in_milliseconds(
    new_session: NewSession,
) -> None:
    driver = new_session("race")
    first, second = driver.both(300, 350), driver.both(310, 400)
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


@pytest.mark.parametrize("seat", ["A", "B"])
def test_a_simulated_slip_is_another_key_of_the_same_half(pairs: type[Task], seat: str) -> None:
    task = pairs(build(pairs.Parameters, {"policy": "race"}))
    stimulus = Stimulus("f j", "", "", seat=seat, halves=("f", "j"))
    for seed in range(50):
        ((_, key),) = task.rehearse(stimulus, Performance(400, slips=True), RandomStreams(seed))
        assert key != stimulus.halves["AB".index(seat)]
        assert task.seat_of(key) == seat

"""Pair policies with keys: rows, scores and feedback per seat."""

import importlib
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
from sar_tui.model.units import MS
from sar_tui.plugins import Catalogue
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.parameters import build
from tests.tasks.pairs.pairs_driver import SHORT, PairsDriver

TASK: Any = importlib.import_module(Catalogue().task("pairs").__module__)
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


def responses(*given: tuple[str, float] | None) -> dict[str, Any]:
    """Return the responses of both seats, asked for f and j, to a key after a time (ms)."""
    found = {}
    for seat, asked, key in zip("AB", "fj", given, strict=True):
        found[seat] = TASK.Response(asked)
        if key is not None:
            pressed, ms = key
            found[seat] = TASK.Response(
                asked, True, pressed, round(ms * MS), latency_ms=ms, is_real=ms >= 100
            )
    return found


@pytest.mark.parametrize(
    ("a", "b", "won"),
    [
        (("f", 500), ("j", 400), (False, True)),
        (("f", 400), ("j", 400), (True, True)),
        (("f", 50), ("j", 400), (False, True)),
        (("x", 300), ("j", 900), (False, True)),
        (("F", 300), None, (True, False)),
        (("x", 300), None, (False, False)),
        (None, None, (False, False)),
    ],
)
def test_the_fastest_right_response_that_is_no_anticipation_wins_a_race(
    a: tuple[str, float] | None, b: tuple[str, float] | None, won: tuple[bool, bool]
) -> None:
    results = TASK.race(responses(a, b), {})
    assert tuple(result.details["won"] for result in results.values()) == won
    assert [result.value for result in results.values()] == [key and key[1] for key in (a, b)]


def test_in_a_race_a_corrected_key_and_an_anticipation_do_not_count(
    new_session: NewSession,
) -> None:
    driver = new_session("race")
    left, right = driver.keys
    presses = [(300.0, wrong(left)), (350.0, left), (900.0, right)]
    rows = driver.by_seat(driver.press_after(*presses))
    assert told(rows, "correct", "won", "response") == [
        (False, False, wrong(left)),
        (True, True, right),
    ]
    rows = driver.both(a_ms=50, b_ms=400)
    assert told(rows, "won", "value") == [(False, None), (True, 400)]
    assert rows["A"].timing.flags == ("anticipation",)


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
    ("a", "b", "together", "between_ms"),
    [
        (("f", 400), ("j", 700), True, 300),
        (("f", 400), ("j", 701), False, 301),
        (("f", 400), ("j", 100), True, 300),
        (("f", 80), ("j", 200), False, 120),
        (("f", 400), ("x", 450), False, 50),
        (("f", 400), None, False, None),
        (None, None, False, None),
    ],
)
def test_together_is_correct_only_if_both_are_correct_within_the_window(
    a: tuple[str, float] | None,
    b: tuple[str, float] | None,
    together: bool,
    between_ms: float | None,
) -> None:
    results = TASK.cooperate(responses(a, b), {}, window_ms=300)
    latest = max(key[1] for key in (a, b) if key) if together else None
    for result, asked, key in zip(results.values(), "fj", (a, b), strict=True):
        assert (result.correct, result.details["together"]) == (together, together)
        assert (result.value, result.details["between_ms"]) == (latest, between_ms)
        assert result.details["right"] == (key is not None and key[0] == asked)


def test_together_both_have_one_result_and_one_outcome(new_session: NewSession) -> None:
    driver = new_session("cooperative", window_ms=300)
    driver.both(300, 500)
    rows = driver.both(600, 400)
    assert told(rows, "together", "between_ms", "value") == [(True, 200, 600)] * 2
    results = {
        (round(one.metric), one.accuracy, one.outcome, one.feedback) for one in ended(driver)
    }
    assert results == {(550, 1.0, "success", "positive")}
    assert {one.valence for one in driver.all(PROPOSED) if one.kind == "feedback"} == {"positive"}


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


@pytest.mark.parametrize("share", [1.0, 0.0])
def test_the_share_of_congruent_trials_is_as_set(new_session: NewSession, share: float) -> None:
    driver = new_session("joint attention", congruent_share=share, prompts_per_attempt=10)
    for _ in range(10):
        driver.press_after((300, "".join(driver.keys)))
    assert {row.details["congruent"] for row in driver.all(TRIAL)} == {bool(share)}


def test_sides_are_balanced_and_their_order_differs_between_attempts(pairs: type[Task]) -> None:
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


def test_the_cueing_effect_is_incongruent_minus_congruent_without_wrong_and_early_responses(
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


def test_each_row_of_a_race_has_the_delay_and_the_gap_of_its_seats_key(
    new_session: NewSession,
) -> None:
    driver = new_session("race")
    left, right = driver.keys
    now = driver.clock.now()
    driver.wait(400)
    driver.press(left, at=now + 300_000_000)
    driver.press(right, at=now + 350_000_000)
    rows = driver.by_seat(driver.all(TRIAL))
    assert [rows[seat].timing.handler_delay_ms for seat in "AB"] == pytest.approx([100, 50])
    assert rows["A"].details["key_gap_ms"] is None
    second = driver.both(310, 400)
    since_ms = ((second["A"].response_at or 0) - (rows["A"].response_at or 0)) / MS
    assert second["A"].details["key_gap_ms"] == pytest.approx(since_ms)


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

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
from sar_tui.model.theme import Theme
from sar_tui.plugins import Catalogue
from tests.tasks.pairs.pairs_driver import SHORT, PairsDriver

NewSession = Callable[..., PairsDriver]


@pytest.fixture(scope="session")
def pairs(catalogue: Catalogue) -> type[Task]:
    return catalogue.task("pairs")


@pytest.fixture
def new_session(pairs: type[Task], calm: Theme) -> NewSession:
    def open_session(policy: str, **parameters: Any) -> PairsDriver:
        return PairsDriver(pairs, calm, policy=policy, **(SHORT | parameters))

    return open_session


def ended(driver: PairsDriver, attempt: int = 1) -> dict[str, Any]:
    """Return the results of an attempt, by seat."""
    return {one.seat: one for one in driver.all(ATTEMPT_ENDED) if one.attempt == attempt}


def feedback_of(driver: PairsDriver, attempt: int = 1) -> dict[str, Any]:
    """Return the proposed feedback on an attempt, by seat."""
    return {
        one.seat: one
        for one in driver.all(PROPOSED)
        if one.kind == "feedback" and one.attempt == attempt
    }


# --- alternate


def test_in_turn_seats_alternate_and_so_does_the_first_seat(new_session: NewSession) -> None:
    driver = new_session("alternate", prompts_per_attempt=3)
    driver.start()
    for _ in range(2):
        for _ in range(3):
            left, right = driver.keys
            driver.press_after((300, left or right))
        driver.wait(1000)
        driver.press("enter")
    assert [(row.attempt, row.seat) for row in driver.all(TRIAL)] == [
        (1, "A"), (1, "B"), (1, "A"), (2, "B"), (2, "A"), (2, "B"),
    ]  # fmt: skip
    assert all(
        row.correct and row.reaction_time_ms == pytest.approx(300) for row in driver.all(TRIAL)
    )
    assert [prompt.seat for prompt in driver.all(PROMPT)] == [row.seat for row in driver.all(TRIAL)]


def test_in_turn_keys_of_the_other_seat_are_ignored_and_flagged(new_session: NewSession) -> None:
    driver = new_session("alternate")
    driver.start()
    left, _ = driver.keys
    assert driver.press_after((200, "j"), (250, "k")) == []
    (row,) = driver.press_after((100, left))
    assert (row.seat, row.correct, row.response) == ("A", True, left)
    assert row.timing.flags == ("other_seat",)


def test_in_turn_keys_of_neither_half_are_ignored(new_session: NewSession) -> None:
    driver = new_session("alternate")
    driver.start()
    left, _ = driver.keys
    assert driver.press_after((200, "space"), (250, "enter"), (270, "left")) == []
    (row,) = driver.press_after((100, left))
    assert (row.correct, row.timing.flags) == (True, ())


def test_in_turn_the_turn_is_announced_before_the_prompt(new_session: NewSession) -> None:
    driver = new_session("alternate")
    driver.start()
    assert {waiting.seat for waiting in driver.all(WAITING) if waiting.stage == "trial"} == {"A"}
    assert {waiting.seat for waiting in driver.all(WAITING) if waiting.stage != "trial"} == {""}
    left, _ = driver.keys
    driver.press_after((300, left))
    driver.to_prompt()
    assert driver.waiting.seat == "B"


def test_in_turn_wrong_keys_and_misses_are_stored(new_session: NewSession) -> None:
    driver = new_session("alternate", response_timeout_ms=1000)
    driver.start()
    left, _ = driver.keys
    (row,) = driver.press_after((300, "x" if left != "x" else "z"))
    assert (row.seat, row.correct, row.details["right"]) == ("A", False, False)
    driver.to_prompt()
    driver.wait(1100)
    assert (driver.last(TRIAL).seat, driver.last(TRIAL).response, driver.last(TRIAL).correct) == (
        "B",
        None,
        False,
    )


def test_in_turn_each_seat_has_its_score_and_feedback_and_the_level_is_shared(
    new_session: NewSession,
) -> None:
    driver = new_session("alternate", prompts_per_attempt=4)
    driver.start()
    for _ in range(4):
        left, right = driver.keys
        driver.press_after((400, left) if left else (1300, right))
    driver.wait(1000)
    results = ended(driver)
    assert (results["A"].outcome, results["A"].feedback, round(results["A"].metric)) == (
        "success",
        "positive",
        400,
    )
    assert (results["B"].outcome, results["B"].feedback, round(results["B"].metric)) == (
        "failure",
        "negative",
        1300,
    )
    assert (results["A"].trials, results["B"].trials) == (2, 2)
    assert driver.all(LEVEL) == []
    assert [(one.seat, one.valence) for one in driver.all(FEEDBACK)] == [
        ("A", "positive"),
        ("B", "negative"),
    ]


def test_the_level_rises_if_both_reach_the_goal(new_session: NewSession) -> None:
    driver = new_session("alternate")
    driver.start()
    for _ in range(2):
        left, right = driver.keys
        driver.press_after((400, left or right))
    driver.wait(1000)
    assert [(change.previous, change.level) for change in driver.all(LEVEL)] == [(1, 2)]
    assert driver.waiting.level == 2


# --- race


def test_in_a_race_the_fastest_correct_response_wins_and_both_are_stored(
    new_session: NewSession,
) -> None:
    driver = new_session("race")
    driver.start()
    rows = driver.both(a_ms=500, b_ms=400)
    assert {seat: (row.correct, row.details["won"]) for seat, row in rows.items()} == {
        "A": (True, False),
        "B": (True, True),
    }
    assert {seat: round(row.reaction_time_ms or 0) for seat, row in rows.items()} == {
        "A": 500,
        "B": 400,
    }


def test_in_a_race_a_slow_correct_key_wins_over_a_fast_wrong_one(new_session: NewSession) -> None:
    driver = new_session("race")
    driver.start()
    left, right = driver.keys
    rows = driver.by_seat(driver.press_after((300, "x" if left != "x" else "z"), (900, right)))
    assert (rows["A"].correct, rows["A"].details["won"]) == (False, False)
    assert (rows["B"].correct, rows["B"].details["won"]) == (True, True)


def test_in_a_race_a_second_key_corrects_nothing(new_session: NewSession) -> None:
    driver = new_session("race")
    driver.start()
    left, right = driver.keys
    rows = driver.by_seat(
        driver.press_after((300, "x" if left != "x" else "z"), (350, left), (900, right))
    )
    assert (rows["A"].response, rows["A"].correct) != (left, True)
    assert rows["B"].details["won"] is True


def test_in_a_race_an_anticipation_does_not_win(new_session: NewSession) -> None:
    driver = new_session("race")
    driver.start()
    rows = driver.both(a_ms=50, b_ms=400)
    assert rows["A"].timing.flags == ("anticipation",)
    assert (rows["A"].details["won"], rows["B"].details["won"]) == (False, True)
    assert (rows["A"].value, round(rows["B"].value or 0)) == (None, 400)


def test_in_a_race_the_other_seat_wins_after_a_miss(new_session: NewSession) -> None:
    driver = new_session("race", response_timeout_ms=1000)
    driver.start()
    left, _ = driver.keys
    assert driver.press_after((300, left)) == []
    driver.wait(1000)
    rows = driver.by_seat(driver.all(TRIAL))
    assert (
        rows["A"].correct,
        rows["A"].details["won"],
        round(rows["A"].reaction_time_ms or 0),
    ) == (True, True, 300)
    assert (rows["B"].response, rows["B"].correct, rows["B"].details["won"]) == (None, False, False)


def test_in_a_race_simultaneous_responses_both_win(new_session: NewSession) -> None:
    driver = new_session("race")
    driver.start()
    assert [row.details["won"] for row in driver.both(400, 400).values()] == [True, True]


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
    driver.start()
    for a, b in zip(a_ms, b_ms, strict=True):
        driver.both(a, b)
    driver.wait(1000)
    answers = feedback_of(driver)
    assert (answers["A"].valence, answers["B"].valence) == valences
    assert f"{won[0]} of 2" in answers["A"].text
    assert f"{won[1]} of 2" in answers["B"].text
    assert [ended(driver)[seat].qualities["won"] for seat in "AB"] == list(won)
    assert [feedback.won for feedback in driver.all(FEEDBACK)] == list(won)


def test_the_level_of_a_race_depends_on_the_goal_not_on_winning(new_session: NewSession) -> None:
    driver = new_session("race")
    driver.start()
    for _ in range(2):
        driver.both(400, 500)
    driver.wait(1000)
    assert [one.outcome for one in ended(driver).values()] == ["success", "success"]
    assert [change.level for change in driver.all(LEVEL)] == [2]


def test_feedback_on_a_race_without_a_winner_depends_on_the_goal(new_session: NewSession) -> None:
    driver = new_session("race", response_timeout_ms=500)
    driver.start()
    for _ in range(2):
        driver.to_prompt()
        driver.wait(600)
    driver.wait(1000)
    assert {feedback.reason for feedback in driver.all(FEEDBACK)} == {"accuracy"}


def test_a_skipped_prompt_of_a_race_has_no_winner(new_session: NewSession) -> None:
    driver = new_session("race")
    driver.start()
    driver.operate("skip")
    assert [(row.seat, row.correct, row.timing.flags) for row in driver.all(TRIAL)] == [
        ("A", False, ("skipped",)),
        ("B", False, ("skipped",)),
    ]
    driver.both(400, 500)
    driver.wait(1000)
    assert [ended(driver)[seat].qualities["won"] for seat in "AB"] == [1, 0]


# --- cooperative


@pytest.mark.parametrize(
    ("b_ms", "together"), [(650, True), (700, True), (701, False), (100, True), (90, False)]
)
def test_together_is_correct_only_if_both_are_correct_within_the_window(
    new_session: NewSession, b_ms: int, together: bool
) -> None:
    driver = new_session("cooperative", window_ms=300)
    driver.start()
    rows = driver.both(a_ms=400, b_ms=b_ms)
    assert {row.correct for row in rows.values()} == {together}
    assert {row.details["together"] for row in rows.values()} == {together}
    assert {row.details["right"] for row in rows.values()} == {True}
    assert [row.details["between_ms"] for row in rows.values()] == pytest.approx(
        [abs(b_ms - 400)] * 2
    )
    values = [row.value for row in rows.values()]
    assert values == (pytest.approx([max(400, b_ms)] * 2) if together else [None, None])


def test_together_one_wrong_key_fails_both(new_session: NewSession) -> None:
    driver = new_session("cooperative")
    driver.start()
    left, right = driver.keys
    rows = driver.by_seat(driver.press_after((400, left), (450, "m" if right != "m" else "n")))
    assert [rows[seat].correct for seat in "AB"] == [False, False]
    assert [rows[seat].details["right"] for seat in "AB"] == [True, False]


def test_together_both_have_one_result_and_one_outcome(new_session: NewSession) -> None:
    driver = new_session("cooperative")
    driver.start()
    driver.both(300, 500)
    driver.both(600, 400)
    driver.wait(1000)
    results = ended(driver)
    assert {
        (round(one.metric), one.accuracy, one.outcome, one.feedback) for one in results.values()
    } == {(550, 1.0, "success", "positive")}
    assert {one.valence for one in feedback_of(driver).values()} == {"positive"}


def test_together_one_response_alone_is_not_correct(new_session: NewSession) -> None:
    driver = new_session("cooperative", response_timeout_ms=800)
    driver.start()
    left, _ = driver.keys
    driver.press_after((300, left))
    driver.wait(800)
    rows = driver.by_seat(driver.all(TRIAL))
    assert [(rows[seat].correct, rows[seat].details["between_ms"]) for seat in "AB"] == [
        (False, None),
        (False, None),
    ]
    assert rows["A"].details["right"] is True


# --- joint attention


def test_the_agent_looks_to_a_side_before_the_prompt_and_the_lead_is_measured(
    new_session: NewSession,
) -> None:
    driver = new_session("joint attention", cue_lead_ms=300)
    driver.start()
    left, right = driver.keys
    (row,) = driver.press_after((350, left or right))
    (cue,) = driver.all(CUE)
    shown = next(record.at for record in driver.records if record.topic is PROMPT)
    given = next(record.at for record in driver.records if record.topic is CUE)
    assert shown - given == 300_000_000
    assert row.details["cue_lead_ms"] == pytest.approx(304)  # and the screen took 4 ms
    assert (cue.side, cue.gaze, cue.gesture) == (row.details["cue"], cue.side, "")
    assert row.details["congruent"] == (cue.side == ("left" if row.seat == "A" else "right"))


@pytest.mark.parametrize(
    ("cue_by", "gaze", "gesture"),
    [("gaze", True, False), ("gesture", False, True), ("both", True, True)],
)
def test_the_cue_is_gaze_gesture_or_both(
    new_session: NewSession, cue_by: str, gaze: bool, gesture: bool
) -> None:
    driver = new_session("joint attention", cue_by=cue_by)
    driver.start()
    cue = driver.last(CUE)
    assert cue.gaze == (cue.side if gaze else "")
    assert cue.gesture == (f"point_{cue.side}" if gesture else "")


def test_only_the_cue_announces_the_side_of_the_prompt(new_session: NewSession) -> None:
    driver = new_session("joint attention")
    driver.start()
    assert {waiting.seat for waiting in driver.all(WAITING)} == {""}
    assert driver.last(PROMPT).seat in ("A", "B")


def test_in_joint_attention_only_keys_on_the_side_of_the_prompt_count(
    new_session: NewSession,
) -> None:
    driver = new_session("joint attention")
    driver.start()
    left, right = driver.keys
    other = "k" if left else "d"
    assert driver.press_after((200, other)) == []
    (row,) = driver.press_after((100, left or right))
    assert (row.seat, row.correct) == ("A" if left else "B", True)
    assert "other_seat" in row.timing.flags


@pytest.mark.parametrize(("share", "congruent"), [(1.0, {True}), (0.0, {False})])
def test_the_share_of_congruent_trials_is_as_set_and_sides_are_balanced(
    new_session: NewSession, share: float, congruent: set[bool]
) -> None:
    driver = new_session("joint attention", congruent_share=share, prompts_per_attempt=10)
    driver.start()
    for _ in range(10):
        left, right = driver.keys
        driver.press_after((300, left or right))
    assert {row.details["congruent"] for row in driver.all(TRIAL)} == congruent
    assert [row.seat for row in driver.all(TRIAL)].count("A") == 5


def test_a_key_after_the_cue_restarts_the_foreperiod_with_a_new_cue(
    new_session: NewSession,
) -> None:
    driver = new_session("joint attention")
    driver.enter()
    driver.press("enter")
    driver.until(lambda: driver.all(CUE))
    driver.press("f")
    driver.to_prompt()
    assert len(driver.all(CUE)) == 2
    left, right = driver.keys
    (row,) = driver.press_after((300, left or right))
    assert row.details["cue_lead_ms"] == pytest.approx(404)
    assert row.timing.false_starts == 1


def test_the_cueing_effect_is_incongruent_minus_congruent(new_session: NewSession) -> None:
    driver = new_session("joint attention", prompts_per_attempt=20)
    driver.start()
    for _ in range(20):
        left, right = driver.keys
        side = "left" if left else "right"
        driver.press_after((300 if driver.last(CUE).side == side else 340, left or right))
    driver.wait(1000)
    for one in ended(driver).values():
        assert one.qualities["congruency_effect_ms"] == pytest.approx(40, abs=0.1)


def test_a_lead_longer_than_the_shortest_foreperiod_is_refused(pairs: type[Task]) -> None:
    from sar_tui.rules.declaration import ParameterError
    from sar_tui.rules.parameters import build

    with pytest.raises(
        ParameterError, match=r"Cue lead \(900 ms\) is longer than the shortest wait \(500 ms\)"
    ):
        build(pairs.Parameters, {"policy": "joint attention", "cue_lead_ms": 900})


# --- perception


def test_presses_repeats_and_gaps_are_counted_per_seat(new_session: NewSession) -> None:
    driver = new_session("race")
    for at, key in ((0, "f"), (10, "j"), (30, "f"), (45, "j"), (50, "space"), (200, "f")):
        driver.press(key, at=driver.clock.now() + at * 1_000_000)
    seen = [
        (one.seat, one.key, one.repeat, one.gap and one.gap // 1_000_000)
        for one in driver.all(PERCEIVED)
    ]
    assert seen == [
        ("A", "f", False, None),
        ("B", "j", False, None),
        ("A", "f", True, 30),
        ("B", "j", True, 35),
        ("", "space", False, None),
        ("A", "f", False, 170),
    ]

"""The thesis' Figures 4.11 to 4.14: their results, and a failure of each claim."""

from collections.abc import Callable
from typing import Any

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.validation import feedback
from sar_tui.validation.charts import draw_feedback
from sar_tui.validation.report import Claim, Conditions, Report
from sar_tui.validation.simulated_sessions import SessionRunner, Simulated

pytestmark = pytest.mark.usefixtures("simulated_once")
Change = Callable[[Simulated], Simulated]


@pytest.fixture
def conditions(catalogue: Catalogue) -> Conditions:
    """Conditions with fewer seeds than in the validation."""
    return Conditions(catalogue, seeds=range(1, 4))


@pytest.fixture
def sessions_become(
    simulated_once: None, monkeypatch: pytest.MonkeyPatch
) -> Callable[[Change], None]:
    """Return a function that changes every simulated session before it is evaluated."""
    run = SessionRunner.run

    def become(change: Change) -> None:
        monkeypatch.setattr(
            SessionRunner, "run", lambda *given, **settings: change(run(*given, **settings))
        )

    return become


def failed(report: Report) -> list[Claim]:
    return [claim for claim in report.claims if not claim.holds]


# --- Figures 4.11 and 4.12


def test_a_poor_user_gets_feedback_on_each_of_twenty_attempts(conditions: Conditions) -> None:
    report = feedback.poor(conditions)
    assert not failed(report)
    assert [row["attempt"] for row in report.rows] == list(range(1, 21)) * 3
    assert {row["feedback"] for row in report.rows} == {"positive", "neutral", "negative"}
    assert report.seen is not None
    assert [sum(row[valence] for valence in feedback.VALENCES) for row in report.seen] == [
        20,
        20,
        20,
    ]


def test_a_competent_user_gets_more_praise_than_a_poor_one(conditions: Conditions) -> None:
    report = feedback.competent(conditions)
    assert not failed(report)
    assert "in all 3 seeds" in report.claims[1].sentence
    praised = {
        user: sum(row["feedback"] == "positive" for row in report.rows if row["user"] == user)
        for user in ("competent", "poor")
    }
    assert praised["competent"] > praised["poor"]


def test_similar_users_fail_the_claim_that_they_differ(
    conditions: Conditions, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(PEOPLE, "competent", PEOPLE["poor"])
    against = [claim.against for claim in failed(feedback.competent(conditions))]
    positives = sum(
        row["feedback"] == "positive" for row in feedback.poor(conditions).rows if row["seed"] == 1
    )
    assert against[0].startswith(f"seed 1: {positives} against {positives}; seed 2: ")
    assert against[1].startswith("they get ")


@pytest.mark.parametrize(
    ("attempt", "given"),
    [
        (
            {"metric": 995.0, "accuracy": 1.0, "feedback": "positive"},
            "within the band, and praised",
        ),
        (
            {"metric": 900.0, "accuracy": 1.0, "feedback": "neutral"},
            "well under the goal, and neutral",
        ),
        ({"metric": 1100.0, "accuracy": 1.0, "feedback": "positive"}, "over the goal, and praised"),
        (
            {"metric": 900.0, "accuracy": 0.5, "feedback": "positive"},
            "half of it wrong, and praised",
        ),
        (
            {"metric": None, "accuracy": 0.9, "feedback": "positive"},
            "nothing measured, and praised",
        ),
    ],
)
def test_feedback_that_contradicts_its_result_fails_the_claim(
    conditions: Conditions,
    sessions_become: Callable[[Change], None],
    attempt: dict[str, Any],
    given: str,
) -> None:
    sessions_become(
        lambda done: done._replace(attempts=[done.attempts[0] | attempt, *done.attempts[1:]])
    )
    (claim,) = failed(feedback.poor(conditions))
    assert (
        claim.against == "poor, seed 1, attempt 1; poor, seed 2, attempt 1; poor, seed 3, attempt 1"
    ), given


# --- Figure 4.13


@pytest.mark.slow
def test_examples_are_of_both_forms_and_each_degree(conditions: Conditions) -> None:
    report = feedback.examples(conditions)
    assert not failed(report)
    assert report.seen is not None
    kinds = [(row["form"], row["feedback"], row["degree"]) for row in report.seen]
    assert len(kinds) == len(set(kinds))
    for form in ("qualitative", "quantitative"):
        valences = [valence for its, valence, _ in kinds if its == form]
        assert set(valences) == set(feedback.VALENCES)
        assert valences == sorted(valences, key=feedback.VALENCES.index)
    figures = [row["text"] for row in report.rows if row["form"] == "quantitative"]
    assert figures
    assert all(any(character.isdigit() for character in text) for text in figures)


@pytest.mark.parametrize(
    ("form", "text", "sentence"),
    [
        ("qualitative", "You were twice as good.", "No qualitative feedback contains a number"),
        ("qualitative", "That makes 3.", "No qualitative feedback contains a number"),
        ("quantitative", "Well done.", "All quantitative feedback contains a figure"),
        ("quantitative", "That took 17 ms.", "Every figure is the result"),
    ],
)
def test_feedback_in_the_wrong_form_or_with_a_wrong_number_fails_a_claim(
    conditions: Conditions,
    sessions_become: Callable[[Change], None],
    form: str,
    text: str,
    sentence: str,
) -> None:
    def say(done: Simulated) -> Simulated:
        if done.attempts[0]["choice"]["form"] != form:
            return done
        first, *others = (action for action in done.actions if action["kind"] == "feedback")
        return done._replace(actions=[first | {"final": first["final"] | {"text": text}}, *others])

    sessions_become(say)
    (claim,) = failed(feedback.examples(conditions))
    assert claim.sentence.startswith(sentence)
    assert claim.against == "; ".join([text] * 3)


# --- Figure 4.14


@pytest.mark.slow
def test_feedback_every_three_attempts_is_on_every_third_attempt(conditions: Conditions) -> None:
    report = feedback.frequency(conditions)
    assert not failed(report)
    for seed in (1, 2, 3):
        rows = [row for row in report.rows if row["seed"] == seed]
        attempts = {every: [row["attempt"] for row in rows if row["every"] == every and row["feedback"] != "none"]
                    for every in (1, 3)}  # fmt: skip
        assert attempts == {1: list(range(1, 21)), 3: [3, 6, 9, 12, 15, 18]}
        results = {
            every: [row["reaction_time_ms"] for row in rows if row["every"] == every]
            for every in (1, 3)
        }
        assert results[1] == results[3], "the same user, whatever is said"
    assert len(report.drawings) == 2


def test_feedback_elsewhere_fails_the_claim(
    conditions: Conditions, sessions_become: Callable[[Change], None]
) -> None:
    def move(done: Simulated) -> Simulated:
        return done._replace(attempts=[done.attempts[0] | {"feedback": "none"}, *done.attempts[1:]])

    sessions_become(move)
    claims = failed(feedback.frequency(conditions))
    assert claims[0].against == "seed 1, attempt 1; seed 2, attempt 1; seed 3, attempt 1"
    assert claims[1].against == "seed 1, every 1; seed 2, every 1; seed 3, every 1", (
        "it was said all the same"
    )


def test_a_setting_that_has_no_effect_fails_the_claim(
    conditions: Conditions, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = SessionRunner.run
    monkeypatch.setattr(
        SessionRunner, "run", lambda place, user, seed, **settings: run(place, user, seed)
    )
    (claim,) = failed(feedback.frequency(conditions))
    assert "3, 6, 9" in claim.sentence
    assert claim.against.startswith("seed 1, attempt 1; seed 1, attempt 2; seed 1, attempt 4; ")


# --- the figures


def row(time: float | None, answer: str) -> dict[str, Any]:
    return {"reaction_time_ms": time, "goal_ms": 1000.0, "feedback": answer, "level": 2}


def test_each_feedback_has_a_marker_and_the_goal_a_line() -> None:
    rows = [
        row(700, "positive"),
        row(1200, "negative"),
        row(1005, "neutral"),
        row(800, "none"),
        row(600, "positive"),
    ]
    title, legend, *lines = draw_feedback(rows, "Someone").split("\n")
    body = "\n".join(lines)
    assert title == "Someone"
    assert legend.split("  ")[-5:] == [
        "▲ positive", "■ neutral", "▼ negative", "· none", "╌ goal 1000"
    ]  # fmt: skip
    assert {mark: body.count(mark) for mark in "▲■▼·"} == {"▲": 2, "■": 1, "▼": 1, "·": 1}
    assert next(line for line in lines if "╌" in line).lstrip().startswith("1000")
    heights = {
        mark: next(number for number, line in enumerate(lines) if mark in line) for mark in "▼■·"
    }
    assert heights["▼"] < heights["■"] < heights["·"]
    assert max(map(len, lines)) <= 80
    assert "\x1b" not in body


def test_an_attempt_without_a_result_is_drawn_below_the_axis() -> None:
    drawn = draw_feedback(
        [row(900, "positive"), row(None, "negative"), row(800, "positive")], "Someone"
    ).split("\n")
    bottom = next(number for number, line in enumerate(drawn) if line.lstrip().startswith("└"))
    assert "×" in drawn[bottom + 1]

"""The thesis' Figures 4.11 to 4.14: their results, and a failure of each claim."""

from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.validation import feedback
from sar_tui.validation.charts import draw_feedback
from sar_tui.validation.report import Claim, Conditions, Report
from sar_tui.validation.simulated_sessions import SessionRunner, Simulated

pytestmark = pytest.mark.usefixtures("simulated_once")
Change = Callable[[Callable[[Simulated], Simulated]], None]


@pytest.fixture
def conditions(catalogue: Catalogue) -> Conditions:
    """Conditions with fewer seeds than in the validation."""
    return Conditions(catalogue, seeds=range(1, 4))


@pytest.fixture
def sessions_become(simulated_once: None, monkeypatch: pytest.MonkeyPatch) -> Change:
    """Return a function that changes every simulated session before it is evaluated."""
    run = SessionRunner.run

    def become(change: Callable[[Simulated], Simulated]) -> None:
        changed = lambda *given, **settings: change(run(*given, **settings))  # noqa: E731
        monkeypatch.setattr(SessionRunner, "run", changed)

    return become


def first_becomes(done: Simulated, **attempt: Any) -> Simulated:
    """Change the first attempt of a session."""
    return done._replace(attempts=[done.attempts[0] | attempt, *done.attempts[1:]])


def failed(report: Report) -> list[Claim]:
    return [claim for claim in report.claims if not claim.holds]


# --- Figures 4.11 and 4.12


def test_a_poor_user_gets_feedback_on_each_of_twenty_attempts(conditions: Conditions) -> None:
    report = feedback.poor(conditions)
    assert not failed(report)
    assert [row["attempt"] for row in report.rows] == list(range(1, 21)) * 3
    assert {row["feedback"] for row in report.rows} == {"positive", "neutral", "negative"}
    assert report.seen is not None
    counts = [sum(row[valence] for valence in feedback.VALENCES) for row in report.seen]
    assert counts == [20, 20, 20]


def test_a_competent_user_gets_more_praise_than_a_poor_one(conditions: Conditions) -> None:
    report = feedback.competent(conditions)
    assert not failed(report)
    assert "in all 3 seeds" in report.claims[1].sentence
    praised = Counter(row["user"] for row in report.rows if row["feedback"] == "positive")
    assert praised["competent"] > praised["poor"]


def test_similar_users_fail_the_claim_that_they_differ(
    conditions: Conditions, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(PEOPLE, "competent", PEOPLE["poor"])
    differ, get = (claim.against for claim in failed(feedback.competent(conditions)))
    rows = [row for row in feedback.poor(conditions).rows if row["seed"] == 1]
    positives = sum(row["feedback"] == "positive" for row in rows)
    assert differ.startswith(f"seed 1: {positives} against {positives}; seed 2: ")
    assert get.startswith("they get ")


@pytest.mark.parametrize(
    ("metric", "accuracy", "given"),
    [
        (995.0, 1.0, "positive"),  # within the band
        (900.0, 1.0, "neutral"),  # well under the goal
        (1100.0, 1.0, "positive"),  # over the goal
        (900.0, 0.5, "positive"),  # half of it wrong
        (None, 0.9, "positive"),  # nothing measured
    ],
)
def test_feedback_that_contradicts_its_result_fails_the_claim(
    conditions: Conditions,
    sessions_become: Change,
    metric: float | None,
    accuracy: float,
    given: str,
) -> None:
    attempt = {"metric": metric, "accuracy": accuracy, "feedback": given}
    sessions_become(partial(first_becomes, **attempt))
    (claim,) = failed(feedback.poor(conditions))
    assert claim.against == "; ".join(f"poor, seed {seed}, attempt 1" for seed in (1, 2, 3))


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
    sessions_become: Change,
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
        results = {}
        for every, expected in ((1, list(range(1, 21))), (3, [3, 6, 9, 12, 15, 18])):
            rows = [row for row in report.rows if (row["seed"], row["every"]) == (seed, every)]
            given = [row["attempt"] for row in rows if row["feedback"] != "none"]
            assert given == expected
            results[every] = [row["reaction_time_ms"] for row in rows]
        assert results[1] == results[3], "the same user, whatever is said"
    assert len(report.drawings) == 2


def test_feedback_elsewhere_fails_the_claim(
    conditions: Conditions, sessions_become: Change
) -> None:
    sessions_become(partial(first_becomes, feedback="none"))
    missing, said, *_ = (claim.against for claim in failed(feedback.frequency(conditions)))
    assert missing == "; ".join(f"seed {seed}, attempt 1" for seed in (1, 2, 3))
    assert said == "; ".join(f"seed {seed}, every 1" for seed in (1, 2, 3))


def test_a_setting_that_has_no_effect_fails_the_claim(
    conditions: Conditions, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = SessionRunner.run
    plain = lambda place, user, seed, **_: run(place, user, seed)  # noqa: E731
    monkeypatch.setattr(SessionRunner, "run", plain)
    (claim,) = failed(feedback.frequency(conditions))
    assert "3, 6, 9" in claim.sentence
    assert claim.against.startswith("seed 1, attempt 1; seed 1, attempt 2; seed 1, attempt 4; ")


# --- the figures


def row(time: float | None, answer: str) -> dict[str, Any]:
    return {"reaction_time_ms": time, "goal_ms": 1000.0, "feedback": answer, "level": 2}


def test_each_feedback_has_a_marker_and_the_goal_a_line() -> None:
    results = ((700, "positive"), (1200, "negative"), (1005, "neutral"), (800, "none"))
    rows = [row(time, answer) for time, answer in (*results, (600, "positive"))]
    title, legend, *lines = draw_feedback(rows, "Someone").split("\n")
    body = "\n".join(lines)
    assert title == "Someone"
    assert legend.endswith("▲ positive  ■ neutral  ▼ negative  · none  ╌ goal 1000")
    assert [body.count(mark) for mark in "▲■▼·"] == [2, 1, 1, 1]
    assert next(line for line in lines if "╌" in line).lstrip().startswith("1000")
    assert body.index("▼") < body.index("■") < body.index("·"), "from slow to fast"
    assert max(map(len, lines)) <= 80
    assert "\x1b" not in body


def test_an_attempt_without_a_result_is_drawn_below_the_axis() -> None:
    rows = [row(900, "positive"), row(None, "negative"), row(800, "positive")]
    _, _, below = draw_feedback(rows, "Someone").partition("└")
    assert "×" in below.split("\n")[1]

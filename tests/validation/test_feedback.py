"""The thesis' Figures 4.11 to 4.14: their results, and a failure of each claim."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.validation import feedback
from sar_tui.validation.charts import draw_feedback
from sar_tui.validation.report import Claim, Conditions
from sar_tui.validation.simulated_sessions import SessionRunner, Simulated

pytestmark = pytest.mark.usefixtures("simulated_once")


@pytest.fixture
def conditions(catalogue: Catalogue) -> Conditions:
    """Conditions with fewer seeds than in the validation."""
    return Conditions(catalogue, seeds=range(1, 4))


@pytest.fixture
def first_attempts_lack_feedback(simulated_once: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Change every simulated session before it is evaluated."""
    run = SessionRunner.run

    def changed(*given: Any, **settings: Any) -> Simulated:
        done = run(*given, **settings)
        first = done.attempts[0] | {"feedback": "none"}
        return done._replace(attempts=[first, *done.attempts[1:]])

    monkeypatch.setattr(SessionRunner, "run", changed)


def failed(claims: Sequence[Claim]) -> list[Claim]:
    return [claim for claim in claims if not claim.holds]


# --- Figures 4.11 and 4.12


def test_a_competent_user_gets_more_praise_than_a_poor_one_and_each_attempt_has_feedback(
    conditions: Conditions,
) -> None:
    report = feedback.competent(conditions)
    assert not failed(report.claims)
    praised = Counter(row["user"] for row in report.rows if row["feedback"] == "positive")
    assert praised["competent"] > praised["poor"]
    poor = [row for row in report.rows if row["user"] == "poor"]
    assert [row["attempt"] for row in poor] == list(range(1, 21)) * 3
    assert {row["feedback"] for row in poor} == {"positive", "neutral", "negative"}
    assert report.seen is not None
    counts = [sum(row[valence] for valence in feedback.VALENCES) for row in report.seen]
    assert counts == [20] * 6


def test_similar_users_fail_the_claim_that_they_differ(
    conditions: Conditions, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(PEOPLE, "competent", PEOPLE["poor"])
    differ, get = (claim.against for claim in failed(feedback.competent(conditions).claims))
    rows = [row for row in feedback.poor(conditions).rows if row["seed"] == 1]
    positives = sum(row["feedback"] == "positive" for row in rows)
    assert differ.startswith(f"seed 1: {positives} against {positives}; seed 2: ")
    assert get.startswith("they get ")


@pytest.mark.usefixtures("first_attempts_lack_feedback")
def test_feedback_that_contradicts_its_result_fails_the_claim(conditions: Conditions) -> None:
    (claim,) = failed(feedback.poor(conditions).claims)
    assert claim.against == "; ".join(f"poor, seed {seed}, attempt 1" for seed in (1, 2, 3))


@pytest.mark.parametrize(
    ("metric", "accuracy", "fitting"),
    [
        (900.0, 0.8, "positive"),
        (989.9, 1.0, "positive"),
        (990.0, 1.0, "neutral"),
        (1010.0, 1.0, "neutral"),
        (1010.1, 1.0, "negative"),
        (900.0, 0.5, "negative"),
        (None, 0.9, "negative"),
    ],
)
def test_feedback_fits_one_valence(metric: float | None, accuracy: float, fitting: str) -> None:
    result = {"reaction_time_ms": metric, "goal_ms": 1000.0, "accuracy": accuracy}
    found = [given for given in feedback.VALENCES if feedback.fits({**result, "feedback": given})]
    assert found == [fitting]


# --- Figure 4.13


@pytest.mark.slow
def test_examples_are_of_both_forms_and_each_degree(conditions: Conditions) -> None:
    report = feedback.examples(conditions)
    assert not failed(report.claims)
    assert report.seen is not None
    kinds = [(row["form"], row["feedback"], row["degree"]) for row in report.seen]
    assert len(kinds) == len(set(kinds))
    for form in ("qualitative", "quantitative"):
        valences = [valence for its, valence, _ in kinds if its == form]
        assert set(valences) == set(feedback.VALENCES)
        assert valences == sorted(valences, key=feedback.VALENCES.index)


def test_feedback_in_the_wrong_form_or_with_a_wrong_number_fails_a_claim(
    conditions: Conditions, monkeypatch: pytest.MonkeyPatch
) -> None:
    said = {"qualitative": "You were twice as good.", "quantitative": "Well done."}
    run = SessionRunner.run

    def say(*given: Any, feedback_form: str) -> Simulated:
        done = run(*given, feedback_form=feedback_form)
        first, *others = (action for action in done.actions if action["kind"] == "feedback")
        changed = first | {"final": first["final"] | {"text": said[feedback_form]}}
        return done._replace(actions=[changed, *others])

    def against() -> list[str]:
        return [claim.against for claim in feedback.examples(conditions).claims]

    monkeypatch.setattr(SessionRunner, "run", say)
    assert against() == ["; ".join([text] * 3) for text in said.values()] + [""]
    said |= {"qualitative": "Very good.", "quantitative": "That took 17 ms."}
    assert against() == ["", "", "; ".join(["That took 17 ms."] * 3)]


@pytest.mark.parametrize("figure", ["0.90", "0.900", "1", "0.30", "16", "20"])
def test_a_figure_is_true_if_it_belongs_to_the_attempt(figure: str) -> None:
    row = {"reaction_time_ms": 900.0, "last_at_level_ms": 1200.0, "goal_ms": 1000.0}
    row |= {"correct": 16, "trials": 20}
    assert feedback.is_true({**row, "text": f"That is {figure}."})
    assert not feedback.is_true({**row, "text": f"That is {figure}9."})


# --- Figure 4.14


def test_feedback_every_three_attempts_is_on_every_third_attempt(conditions: Conditions) -> None:
    report = feedback.frequency(conditions._replace(seeds=range(1, 2)))
    assert not failed(report.claims)
    assert len(report.drawings) == 2
    times = {}
    for every, expected in ((1, list(range(1, 21))), (3, [3, 6, 9, 12, 15, 18])):
        rows = [row for row in report.rows if row["every"] == every]
        assert [row["attempt"] for row in rows if row["feedback"] != "none"] == expected
        times[every] = [row["reaction_time_ms"] for row in rows]
    assert times[1] == times[3], "the same user, whatever is said"


@pytest.mark.usefixtures("first_attempts_lack_feedback")
def test_feedback_elsewhere_fails_the_claim(conditions: Conditions) -> None:
    report = feedback.frequency(conditions._replace(seeds=range(1, 3)))
    missing, said = (claim.against for claim in failed(report.claims))
    assert missing == "seed 1, attempt 1; seed 2, attempt 1"
    assert said == "seed 1, every 1; seed 2, every 1"


def test_a_setting_that_has_no_effect_fails_the_claim(
    conditions: Conditions, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = SessionRunner.run
    plain = lambda place, user, seed, **_: run(place, user, seed)  # noqa: E731
    monkeypatch.setattr(SessionRunner, "run", plain)
    (claim,) = failed(feedback.frequency(conditions).claims)
    assert claim.against.startswith("seed 1, attempt 1; seed 1, attempt 2; seed 1, attempt 4; ")


# --- the figures


def drawn(*results: tuple[float | None, str]) -> list[str]:
    rows = [
        {"reaction_time_ms": time, "goal_ms": 1000.0, "feedback": given, "level": 2}
        for time, given in results
    ]
    return draw_feedback(rows, "Someone").split("\n")


def test_each_feedback_has_a_marker_and_the_goal_a_line() -> None:
    many = [(700, "positive"), (1200, "negative"), (1005, "neutral"), (800, "none")]
    title, legend, *lines = drawn(*many, (600, "positive"))
    body = "\n".join(lines)
    assert title == "Someone"
    assert legend.endswith("▲ positive  ■ neutral  ▼ negative  · none  ╌ goal 1000")
    assert [body.count(mark) for mark in "▲■▼·"] == [2, 1, 1, 1]
    assert next(line for line in lines if "╌" in line).lstrip().startswith("1000")
    assert body.index("▼") < body.index("■") < body.index("·"), "from slow to fast"
    assert max(map(len, lines)) <= 80


def test_an_attempt_without_a_result_is_drawn_below_the_axis() -> None:
    lines = drawn((900, "positive"), (None, "negative"), (800, "positive"))
    axis = next(number for number, line in enumerate(lines) if "└" in line)
    assert "×" in lines[axis + 1]

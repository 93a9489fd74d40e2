"""Feedback schedules: when each gives feedback, its content and reason, and a failure of each
claim.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.validation import policies
from sar_tui.validation.report import Conditions, Report, Row
from sar_tui.validation.simulated_sessions import SessionRunner, Simulated


@pytest.fixture(scope="module")
def report(catalogue: Catalogue) -> Report:
    return policies.run(Conditions(catalogue))


def rows(report: Report, schedule: str) -> list[Row]:
    return [row for row in report.rows if row["schedule"] == schedule]


def with_feedback(report: Report, schedule: str) -> list[int]:
    return [row["attempt"] for row in rows(report, schedule) if row["feedback"]]


@pytest.mark.slow
def test_all_claims_hold_and_every_schedule_has_twenty_attempts(report: Report) -> None:
    assert [claim for claim in report.claims if not claim.holds] == []
    for schedule in ("every", "faded", "bandwidth", "summary", "request", "none"):
        assert len(rows(report, schedule)) == 20


def test_the_participant_performs_the_same_under_every_schedule(report: Report) -> None:
    assert (
        len(
            {
                tuple(row["reaction_time_ms"] for row in rows(report, name))
                for name in policies.SCHEDULES
            }
        )
        == 1
    )


def test_every_and_summary_give_feedback_at_their_interval(report: Report) -> None:
    assert with_feedback(report, "every") == list(range(2, 21, 2))
    assert with_feedback(report, "summary") == [5, 10, 15, 20]
    assert {row["attempts"] for row in rows(report, "summary") if row["feedback"]} == {5}


def test_faded_feedback_becomes_rarer_with_success(report: Report) -> None:
    given = with_feedback(report, "faded")
    gaps = [later - earlier for earlier, later in pairwise(given)]
    assert given[0] == 1
    assert gaps[0] < gaps[-1]
    assert max(row["interval"] for row in rows(report, "faded")) > min(
        row["interval"] for row in rows(report, "faded")
    )


def test_bandwidth_feedback_is_only_on_results_outside_the_tolerance(report: Report) -> None:
    for row in rows(report, "bandwidth"):
        assert row["tolerance"] == 100
        assert (abs(row["reaction_time_ms"] - row["goal_ms"]) > 100) == bool(row["feedback"])


def test_on_request_only_requested_feedback_is_given(report: Report) -> None:
    asked = [row["attempt"] for row in rows(report, "request") if row["asked"]]
    assert 0 < len(asked) < 20
    assert with_feedback(report, "request") == asked
    assert {row["asked"] for name in ("every", "none") for row in rows(report, name)} == {False}


def test_without_feedback_nothing_is_said(report: Report) -> None:
    assert {(row["feedback"], row["text"], row["due"]) for row in rows(report, "none")} == {
        (None, "", False)
    }


def test_the_table_has_one_line_per_schedule_with_its_reasons(report: Report) -> None:
    assert report.seen is not None
    seen = {row["schedule"]: row for row in report.seen}
    assert seen["summary"]["answered"] == "5, 10, 15, 20"
    assert seen["summary"]["why_not"] == "Due every 5 attempts; 4 since the last."
    assert (seen["none"]["answered"], seen["none"]["why"]) == ("", None)


def altered(attempt: dict[str, Any]) -> Callable[[Simulated], Simulated]:
    return lambda done: done._replace(
        attempts=[*done.attempts[:9], done.attempts[9] | attempt, *done.attempts[10:]]
    )


def silent(done: Simulated) -> Simulated:
    return done._replace(actions=[])


def hurried(done: Simulated) -> Simulated:
    """Give all feedback at the end of its attempt."""
    ends = {attempt["attempt"]: attempt["ended_ns"] for attempt in done.attempts}
    actions = [
        action | {"decided_ns": ends.get(action["final"]["attempt"])} for action in done.actions
    ]
    return done._replace(actions=[action for action in actions if action["decided_ns"]])


def late(done: Simulated) -> Simulated:
    """Give all feedback a minute later."""
    return done._replace(
        actions=[row | {"decided_ns": row["decided_ns"] + 60 * 10**9} for row in done.actions]
    )


def reworded(done: Simulated) -> Simulated:
    return done._replace(
        actions=[row | {"final": row["final"] | {"text": "Well done."}} for row in done.actions]
    )


@pytest.mark.parametrize(
    ("change", "schedule", "sentence", "against"),
    [
        (
            altered({"feedback": "none"}),
            "every",
            "every: feedback after every 2",
            "attempts 10 differ",
        ),
        (
            altered({"feedback": "positive"}),
            "faded",
            "faded: one attempt rarer",
            "attempts 10 differ",
        ),
        (altered({"metric": 1000.0}), "bandwidth", "bandwidth: only", "attempts 10 differ"),
        (
            altered({"feedback": "none"}),
            "summary",
            "summary: a summary after every 5",
            "attempts 10 differ",
        ),
        (lambda done: done._replace(asked=[]), "request", "request: only after", "differ"),
        (altered({"feedback": "positive"}), "none", "none: no feedback", "attempts 10 differ"),
        (
            silent,
            "every",
            "The log holds the text of each feedback",
            "every, attempt 2; every, attempt 4; ",
        ),
        (hurried, "every", "Feedback that is due comes 1500 ms after", "every, attempt 2; "),
        (late, "every", "No attempt begins before", "every, attempt 2; "),
        (
            reworded,
            "summary",
            "A summary covers 5 attempts",
            "summary, attempt 5; summary, attempt 10; ",
        ),
    ],
)
@pytest.mark.usefixtures("simulated_once")
def test_a_contradicting_log_fails_the_claim(
    catalogue: Catalogue,
    monkeypatch: pytest.MonkeyPatch,
    change: Callable[[Simulated], Simulated],
    schedule: str,
    sentence: str,
    against: str,
) -> None:
    run = SessionRunner.run
    monkeypatch.setattr(
        SessionRunner, "run", lambda *given, **settings: change(run(*given, **settings))
    )
    monkeypatch.setattr(policies, "SCHEDULES", {schedule: policies.SCHEDULES[schedule]})
    claims = {claim.sentence: claim.against for claim in policies.run(Conditions(catalogue)).claims}
    (found,) = (its for said, its in claims.items() if said.startswith(sentence))
    assert against in found


@pytest.mark.usefixtures("simulated_once")
def test_an_attempt_without_a_reason_fails_the_claim(
    catalogue: Catalogue, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = SessionRunner.run

    def forgetful(*given: Any, **settings: Any) -> Simulated:
        done = run(*given, **settings)
        first, *others = done.attempts
        return done._replace(attempts=[first | {"choice": first["choice"] | {"why": " "}}, *others])

    monkeypatch.setattr(SessionRunner, "run", forgetful)
    monkeypatch.setattr(policies, "SCHEDULES", {"none": policies.SCHEDULES["none"]})
    claims = policies.run(Conditions(catalogue)).claims
    (reason,) = (claim for claim in claims if claim.sentence.startswith("The log gives a reason"))
    assert reason.against == "none, attempt 1"

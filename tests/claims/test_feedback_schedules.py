"""Feedback schedules: a simulated session under each, and checks of the logged times, texts and
reasons.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.validation.report import Claim, Conditions, Report, Row
from sar_tui.validation.simulated_sessions import Simulated, session_runner

USER = "competent"
EVERY, FADE, BANDWIDTH_PERCENT, SUMMARY = 2, 2, 10.0, 5
DELAY_MS = 1500
LEAST_ACCURACY = 0.8
_NEAR_MS = 1.0


class Schedule(NamedTuple):
    """Settings of a schedule, its promise, and the attempts that should get feedback."""

    settings: dict[str, Any]
    promise: str
    expected: Callable[[Sequence[Row]], list[int]]


@pytest.mark.usefixtures("simulated_once")
def test_each_schedule_keeps_its_promise_and_its_log_says_why(catalogue: Catalogue) -> None:
    report = run(Conditions(catalogue))
    assert [claim for claim in report.claims if not claim.holds] == []
    times = {
        tuple(row["reaction_time_ms"] for row in report.rows if row["schedule"] == name)
        for name in SCHEDULES
    }
    assert [len(each) for each in times] == [20], "the same performance under every schedule"


def run(conditions: Conditions) -> Report:
    """Return one row per attempt under each schedule, with the same user and seed."""
    rows: list[Row] = []
    claims: list[Claim] = []
    with session_runner(conditions.catalogue, conditions.known) as runner:
        for name, schedule in SCHEDULES.items():
            settings = {
                "feedback_schedule": name,
                "feedback_delay_ms": DELAY_MS,
                **schedule.settings,
            }
            done = runner.run(USER, conditions.seeds[0], **settings)
            found = _rows(name, done)
            wrong = sorted(
                set(schedule.expected(found)) ^ {row["attempt"] for row in found if row["feedback"]}
            )
            claims.append(
                Claim(schedule.promise, f"attempts {_listed(wrong)} differ" if wrong else "")
            )
            rows += found
    claims += [
        _claim(
            rows,
            "The log gives a reason for each attempt.",
            lambda row: bool(row["why"].strip().endswith(".")),
        ),
        _claim(
            rows,
            "The log holds the text of each feedback that it reports, and no other.",
            lambda row: bool(row["text"]) == bool(row["feedback"]),
        ),
        _claim(
            rows,
            f"Feedback that is due comes {DELAY_MS} ms after its attempt, requested feedback at "
            "once.",
            lambda row: (
                row["answered_after_ms"] is None
                or abs(row["answered_after_ms"] - (0 if row["asked"] else DELAY_MS)) <= _NEAR_MS
            ),
        ),
        _claim(
            rows,
            "No attempt begins before the last one's feedback.",
            lambda row: not row["next_began_before"],
        ),
        _claim(
            [row for row in rows if row["schedule"] == "summary" and row["feedback"]],
            f"A summary covers {SUMMARY} attempts, and says how many of them reached the goal.",
            lambda row: (
                row["attempts"] == SUMMARY and str(row["reached_of_them"]) in row["text"].split()
            ),
        ),
    ]
    return Report(rows, [], claims)


# --- the promises of the schedules, computed from the participant's results


def _each(every: int) -> Callable[[Sequence[Row]], list[int]]:
    return lambda rows: [row["attempt"] for row in rows if row["attempt"] % every == 0]


def _faded(rows: Sequence[Row]) -> list[int]:
    """Return the attempts with feedback: the interval grows by one per ``FADE`` more successes than
    failures.
    """
    given, ahead, at_last, last = [], 0, 0, 0
    for row in rows:
        ahead = max(0, ahead + (1 if row["outcome"] == "success" else -1))
        if row["attempt"] - last >= 1 + min(ahead, at_last) // FADE:
            last, at_last = row["attempt"], ahead
            given.append(last)
    return given


def _outside(rows: Sequence[Row]) -> list[int]:
    return [
        row["attempt"]
        for row in rows
        if row["reaction_time_ms"] is None
        or row["accuracy"] < LEAST_ACCURACY
        or abs(row["reaction_time_ms"] - row["goal_ms"]) > row["goal_ms"] * BANDWIDTH_PERCENT / 100
    ]


SCHEDULES: dict[str, Schedule] = {
    "every": Schedule(
        {"feedback_every": EVERY},
        f"every: feedback after every {EVERY} attempts only.",
        _each(EVERY),
    ),
    "faded": Schedule(
        {"feedback_fade": FADE},
        f"faded: one attempt rarer for each {FADE} more successes than failures.",
        _faded,
    ),
    "bandwidth": Schedule(
        {"feedback_tolerance": BANDWIDTH_PERCENT},
        f"bandwidth: only on results more than {BANDWIDTH_PERCENT:g} % from the goal, or with too "
        "few right responses.",
        _outside,
    ),
    "summary": Schedule(
        {"feedback_every": SUMMARY},
        f"summary: a summary after every {SUMMARY} attempts.",
        _each(SUMMARY),
    ),
    "request": Schedule(
        {},
        "request: only after attempts for which the participant asked.",
        lambda rows: [row["attempt"] for row in rows if row["asked"]],
    ),
    "none": Schedule({}, "none: no feedback.", lambda rows: []),
}


# --- sessions as rows


def _rows(schedule: str, done: Simulated) -> list[Row]:
    rows: list[Row] = []
    begins = [attempt["started_ns"] for attempt in done.attempts[1:]]
    outcomes = [attempt["outcome"] for attempt in done.attempts]
    for attempt, next_begins in zip(done.attempts, [*begins, None], strict=True):
        number, choice = attempt["attempt"], attempt["choice"]
        said = done.feedback.get(number)
        asked = next(
            (at for at in done.asked if at >= attempt["ended_ns"] and (next_begins or at + 1) > at),
            None,
        )
        since = attempt["ended_ns"] if asked is None else asked
        rows.append(
            {
                "schedule": schedule,
                "attempt": number,
                "level": attempt["level"],
                "reaction_time_ms": attempt["metric"],
                "goal_ms": attempt["goal"],
                "accuracy": attempt["accuracy"],
                "outcome": attempt["outcome"],
                "feedback": None if attempt["feedback"] == "none" else attempt["feedback"],
                **{name: choice[name] for name in CHOICE},
                "reached_of_them": outcomes[max(0, number - choice["attempts"]) : number].count(
                    "success"
                ),
                "asked": asked is not None,
                "answered_after_ms": (said["decided_ns"] - since) / 1e6 if said else None,
                "next_began_before": bool(
                    said and next_begins and next_begins < said["decided_ns"]
                ),
                "text": said["final"]["text"] if said else "",
            }
        )
    return rows


CHOICE = (
    "due",
    "why",
    "since",
    "interval",
    "tolerance",
    "attempts",
    "content",
    "form",
    "compared_with",
    "degree",
)
"""Fields of `messages.FeedbackChoice` that a row repeats."""


def _claim(rows: Sequence[Row], sentence: str, holds: Callable[[Row], bool]) -> Claim:
    wrong = [f"{row['schedule']}, attempt {row['attempt']}" for row in rows if not holds(row)]
    return Claim(sentence, "; ".join(wrong) if rows else "there was none")


def _listed(attempts: Sequence[int]) -> str:
    return ", ".join(map(str, attempts))

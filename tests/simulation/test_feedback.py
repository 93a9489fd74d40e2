"""Feedback in simulated sessions is given and stored as each schedule asks for."""

from contextlib import closing
from pathlib import Path
from typing import Any

import msgspec
import pytest

from sar_tui.loop.session_phase import REQUEST_KEY
from sar_tui.loop.topics import ATTEMPT_ENDED, FEEDBACK, KEY, PROPOSED
from sar_tui.model.units import MS
from sar_tui.plugins import Catalogue
from sar_tui.rules.feedback import RAREST
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import connect

SCHEDULES = ("every", "faded", "bandwidth", "summary", "request", "none")


class StoredSession:
    """A simulated session of the keyboard task, read from the database."""

    def __init__(self, data: Path, catalogue: Catalogue, **parameters: Any) -> None:
        plan = make_plan(catalogue, "keyboard", ["SIM"], parameters, seed=4, mode="simulated")
        self.parameters = plan.parameters
        name = simulate(plan, PEOPLE["average"], data, catalogue)
        with closing(connect(data)) as database:
            self.attempts = sessions.rows(database, "attempts", name)
            self.actions = sessions.rows(database, "actions", name)
            self.records = list(sessions.history(database, name))

    def all(self, topic: Any) -> list[Any]:
        return [record.message for record in self.records if record.topic is topic]

    @property
    def with_feedback(self) -> list[int]:
        return [row["attempt"] for row in self.attempts if row["feedback"] != "none"]

    @property
    def said(self) -> list[sessions.Row]:
        """The actions of the agent that are feedback."""
        return [action for action in self.actions if action["kind"] == "feedback"]


@pytest.fixture(scope="module")
def by_schedule(
    tmp_path_factory: pytest.TempPathFactory, catalogue: Catalogue
) -> dict[str, StoredSession]:
    """A session under each schedule, with values other than the defaults for the other feedback
    settings.
    """
    return {
        schedule: StoredSession(
            tmp_path_factory.mktemp("data"),
            catalogue,
            attempts=16,
            prompts_per_attempt=5,
            start_level=3,
            feedback_schedule=schedule,
            feedback_every=4,
            feedback_fade=1,
            feedback_tolerance=12,
            feedback_form="quantitative",
            feedback_compared_with="best attempt",
            feedback_delay_ms=700,
        )
        for schedule in SCHEDULES
    }


@pytest.fixture(params=SCHEDULES)
def session(request: pytest.FixtureRequest, by_schedule: dict[str, StoredSession]) -> StoredSession:
    return by_schedule[request.param]


def test_each_practice_attempt_gets_feedback_and_the_schedule_starts_after_it(
    data: Path, catalogue: Catalogue
) -> None:
    settings = {"attempts": 7, "practice_attempts": 2, "prompts_per_attempt": 5}
    session = StoredSession(data, catalogue, feedback_every=3, **settings)
    assert session.with_feedback == [1, 2, 5, 8]


@pytest.mark.slow
def test_people_perform_the_same_under_every_schedule(
    by_schedule: dict[str, StoredSession],
) -> None:
    results = {tuple(row["metric"] for row in session.attempts) for session in by_schedule.values()}
    assert [len(each) for each in results] == [16]


def test_every_attempt_stores_its_feedback_choice(session: StoredSession) -> None:
    schedule = session.parameters.feedback_schedule
    declared = {
        "schedule": schedule,
        "delay_ms": 0 if schedule == "request" else 700,
        "content": "results",
        "form": "quantitative",
        "compared_with": "best attempt",
    }
    assert len(session.attempts) == 16
    for row in session.attempts:
        assert declared.items() <= row["choice"].items()
        assert row["choice"]["due"] == (row["feedback"] != "none")
    some = 0 < len(session.with_feedback) < 16
    assert some == (schedule != "none")


def test_the_stored_reason_for_feedback_is_true(session: StoredSession) -> None:
    """The row alone shows whether feedback on the attempt was due."""
    since = 0
    for row in session.attempts:
        choice = row["choice"]
        since += 1
        assert choice["since"] == since
        match choice["schedule"]:
            case "every" | "summary":
                assert choice["interval"] == 4
                assert choice["due"] == (since == 4)
                assert f"{since} since the last" in choice["why"]
            case "faded":
                assert 1 <= choice["interval"] <= RAREST
                assert choice["due"] == (since >= choice["interval"])
            case "bandwidth":
                assert choice["tolerance"] == pytest.approx(0.12 * row["goal"])
                off = abs(row["metric"] - row["goal"])
                failed = row["accuracy"] < session.parameters.min_accuracy
                assert choice["due"] == (failed or off > choice["tolerance"])
            case "request":
                assert choice["why"].startswith("The participant asked") == choice["due"]
            case "none":
                assert not choice["due"]
        if row["feedback"] != "none":
            since = 0


def test_the_row_and_the_feedback_have_the_choice_of_the_last_message(
    session: StoredSession,
) -> None:
    by_attempt = {message.attempt: message for message in session.all(ATTEMPT_ENDED)}
    assert [row["choice"] for row in session.attempts] == [
        msgspec.to_builtins(by_attempt[row["attempt"]].choice) for row in session.attempts
    ]
    given = session.all(FEEDBACK)
    assert [feedback.attempt for feedback in given] == session.with_feedback
    for feedback in given:
        assert feedback.choice == by_attempt[feedback.attempt].choice
        assert feedback.valence == by_attempt[feedback.attempt].feedback


def test_feedback_is_said_as_chosen_when_it_was_due_and_before_the_next_attempt(
    session: StoredSession,
) -> None:
    rows = {row["attempt"]: row for row in session.attempts}
    assert [action["proposed"]["attempt"] for action in session.said] == session.with_feedback
    if session.parameters.feedback_schedule == "request":
        due = [key.at for key in session.all(KEY) if key.key == REQUEST_KEY]
    else:
        due = [rows[attempt]["ended_ns"] + 700 * MS for attempt in session.with_feedback]
    assert [action["decided_ns"] for action in session.said] == due
    for action in session.said:
        attempt = action["proposed"]["attempt"]
        final, row = action["final"], rows[attempt]
        assert action["decision"] == "accepted"
        assert (final["valence"], final["degree"]) == (row["feedback"], row["choice"]["degree"])
        assert any(character.isdigit() for character in final["text"])
        if attempt < 16:
            assert rows[attempt + 1]["started_ns"] > action["decided_ns"]


def test_a_summary_says_how_many_of_its_attempts_reached_the_goal(
    by_schedule: dict[str, StoredSession],
) -> None:
    session = by_schedule["summary"]
    outcomes = [row["outcome"] for row in session.attempts]
    for action in session.said:
        last = action["proposed"]["attempt"]
        assert session.attempts[last - 1]["choice"]["attempts"] == 4
        reached = outcomes[last - 4 : last].count("success")
        assert str(reached) in action["final"]["text"].split()


def test_each_proposal_was_said_or_dropped(session: StoredSession) -> None:
    proposed = [proposal.id for proposal in session.all(PROPOSED)]
    assert [action["id"] for action in session.actions] == proposed
    for action in session.actions:
        assert action["decision"] == ("dropped" if action["final"] is None else "accepted")

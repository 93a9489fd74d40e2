"""Feedback in simulated sessions is given and stored as set."""

from collections import Counter
from pathlib import Path
from typing import Any

import msgspec
import pytest

from sar_tui.loop.session_phase import REQUEST_KEY
from sar_tui.loop.topics import ALL, ATTEMPT_ENDED, FEEDBACK, KEY, PROPOSED
from sar_tui.plugins import Catalogue
from sar_tui.rules.feedback import RAREST
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import connect
from tests.examples import first

SCHEDULES = ("every", "faded", "bandwidth", "summary", "request", "none")
SEEDS = range(1, 13)


class StoredSession:
    """A simulated session, read from the database."""

    def __init__(
        self, data: Path, user: str, seed: int, task: str = "keyboard", **parameters: Any
    ) -> None:
        catalogue = Catalogue()
        plan = make_plan(catalogue, task, ["SIM"], parameters, seed=seed, mode="simulated")
        self.parameters = plan.parameters
        self.id = simulate(plan, PEOPLE[user], data, catalogue)
        database = connect(data)
        self.attempts = sessions.rows(database, "attempts", self.id)
        self.actions = sessions.rows(database, "actions", self.id)
        self.records = list(sessions.history(database, self.id))
        database.close()

    def all(self, topic: Any) -> list[Any]:
        return [record.message for record in self.records if record.topic is topic]

    @property
    def with_feedback(self) -> list[int]:
        return [row["attempt"] for row in self.attempts if row["feedback"] != "none"]

    @property
    def valences(self) -> Counter[str]:
        return Counter(row["feedback"] for row in self.attempts)


# --- the thesis' Figures 4.11 to 4.14


@pytest.mark.parametrize("every", [1, 3])
@pytest.mark.parametrize("seed", first(1, SEEDS))
def test_competent_users_are_praised_more_often_than_poor_ones_in_every_session(
    data: Path, seed: int, every: int
) -> None:
    """Feedback on each attempt (Figures 4.11, 4.12), and on every third (4.13, 4.14)."""
    settings = {
        "attempts": 20,
        "prompts_per_attempt": 8,
        "difficulty_policy": "fixed",
        "start_level": 5,
    }
    users = {
        user: StoredSession(data, user, seed, feedback_every=every, **settings)
        for user in ("poor", "competent")
    }
    poor, competent = users["poor"].valences, users["competent"].valences
    assert competent["positive"] > poor["positive"]
    assert poor["negative"] > competent["negative"]
    for session in users.values():
        assert session.with_feedback == list(range(every, 21, every))


def test_feedback_every_three_attempts_is_on_every_third_attempt(data: Path) -> None:
    session = StoredSession(
        data, "average", 1, attempts=20, prompts_per_attempt=5, feedback_every=3
    )
    assert session.with_feedback == [3, 6, 9, 12, 15, 18]
    assert [feedback.attempt for feedback in session.all(FEEDBACK)] == session.with_feedback
    said = [
        action["proposed"]["attempt"] for action in session.actions if action["kind"] == "feedback"
    ]
    assert said == session.with_feedback


def test_each_practice_attempt_gets_feedback_and_the_schedule_starts_after_it(data: Path) -> None:
    session = StoredSession(
        data, "average", 1, attempts=7, practice_attempts=2, prompts_per_attempt=5, feedback_every=3
    )
    assert session.with_feedback == [1, 2, 5, 8]


# --- each schedule: when, what and why


@pytest.fixture(scope="module", params=SCHEDULES)
def session(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> StoredSession:
    """A session under each schedule, with values other than the defaults for the other feedback
    settings.
    """
    return StoredSession(
        tmp_path_factory.mktemp("data"),
        "average",
        4,
        attempts=16,
        prompts_per_attempt=5,
        start_level=3,
        feedback_schedule=request.param,
        feedback_every=4,
        feedback_fade=1,
        feedback_tolerance=12,
        feedback_form="quantitative",
        feedback_compared_with="best attempt",
        feedback_delay_ms=700,
    )


def test_every_attempt_stores_its_feedback_choice(session: StoredSession) -> None:
    schedule = session.parameters.feedback_schedule
    assert len(session.attempts) == 16
    for row in session.attempts:
        choice = row["choice"]
        assert (choice["schedule"], choice["delay_ms"]) == (
            schedule,
            0 if schedule == "request" else 700,
        )
        assert choice["due"] == (row["feedback"] != "none")
        assert (choice["content"], choice["form"], choice["compared_with"]) == (
            "results", "quantitative", "best attempt",
        )  # fmt: skip
        assert choice["degree"] in ("slight", "clear", "strong")
        assert choice["why"].endswith(".")


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
                asked, waits = (
                    "The participant asked for it.",
                    "Feedback is given when the participant asks for it.",
                )
                assert choice["why"] == (asked if choice["due"] else waits)
            case "none":
                assert (choice["due"], choice["why"]) == (False, "No feedback is given.")
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


def test_feedback_is_said_as_chosen_and_when_it_was_due(session: StoredSession) -> None:
    rows = {row["attempt"]: row for row in session.attempts}
    asked = [key.at for key in session.all(KEY) if key.key == REQUEST_KEY]
    on_request = session.parameters.feedback_schedule == "request"
    said = [action for action in session.actions if action["kind"] == "feedback"]
    assert [action["proposed"]["attempt"] for action in said] == session.with_feedback
    due = (
        asked
        if on_request
        else [rows[attempt]["ended_ns"] + 700_000_000 for attempt in session.with_feedback]
    )
    assert [action["decided_ns"] for action in said] == due
    for action in said:
        row = rows[action["proposed"]["attempt"]]
        assert action["decision"] == "accepted"
        assert action["final"]["valence"] == row["feedback"]
        assert action["final"]["degree"] == row["choice"]["degree"]
        assert any(character.isdigit() for character in action["final"]["text"])


def test_each_schedule_except_none_gives_feedback_on_some_attempts(session: StoredSession) -> None:
    count = len(session.with_feedback)
    assert count == 0 if session.parameters.feedback_schedule == "none" else 0 < count < 16


def test_each_proposal_was_said_or_has_a_reason_why_it_was_not(session: StoredSession) -> None:
    assert [action["id"] for action in session.actions] == [
        proposal.id for proposal in session.all(PROPOSED)
    ]
    for action in session.actions:
        assert action["decision"] in ("accepted", "dropped")
        assert (action["final"] is None) == (action["decision"] == "dropped")


def test_every_message_can_be_read_back(session: StoredSession) -> None:
    for record in session.records:
        assert msgspec.json.decode(
            msgspec.json.encode(record.message), type=ALL[record.topic.name].type
        ) == (record.message)

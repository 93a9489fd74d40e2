"""The intervention report on simulated sessions: its figures are those of queries on the tables."""

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.model import messages as m
from sar_tui.reports.intervention import Acts, Record, changes_played, intervention
from sar_tui.reports.intervention_words import sections
from sar_tui.store.programmes import Programme
from sar_tui.store.records import Record as PersonRecord
from tests.program import Call

BRIEF = ("--attempts", 6, "--set", "prompts_per_attempt=3", "--json")


@pytest.fixture
def study(call: Call) -> dict[str, Any]:
    """The report on three sessions: two of one person, one of another with an operator."""
    call("simulate", "keyboard", "-p", "P01", "--user", "average", "--seed", 1, *BRIEF)
    call(
        "simulate",
        "keyboard",
        "-p",
        "P01",
        "--user",
        "average",
        "--seed",
        2,
        *BRIEF,
        "--set",
        "start_level=3",
    )
    call(
        "simulate",
        "reaching",
        "-p",
        "P02",
        "--user",
        "poor",
        "--seed",
        3,
        "--attempts",
        2,
        "--operator",
        "careful",
    )
    found: dict[str, Any] = call("report", "intervention", "--all", "--simulated", "--json").json
    return found


def test_the_dose_is_that_of_the_tables(study: dict[str, Any], tmp_path: Path) -> None:
    with closing(sqlite3.connect(tmp_path / "data" / "sar-tui.db")) as database:
        expected = database.execute(
            "SELECT participant, count(DISTINCT attempts.session), count(*), sum(trials),"
            " round(sum(ended_ns - started_ns) / 6e10, 2)"
            " FROM attempts JOIN seats USING (session, seat) GROUP BY participant ORDER BY "
            "participant"
        ).fetchall()
    told = [
        (
            each["participant"],
            each["sessions"],
            each["done"],
            each["repetitions"],
            each["time_on_task_min"],
        )
        for each in study["dose"]
    ]
    assert told == expected
    assert study["adherence"] == 1
    assert study["operated"] == 1


def test_the_challenge_is_that_of_the_tables(study: dict[str, Any], tmp_path: Path) -> None:
    with closing(sqlite3.connect(tmp_path / "data" / "sar-tui.db")) as database:
        expected = database.execute(
            "SELECT participant, min(level), max(level), round(avg(outcome='success'), 4)"
            " FROM attempts JOIN seats USING (session, seat) GROUP BY participant ORDER BY "
            "participant"
        ).fetchall()
        changes = database.execute(
            "SELECT participant, sum(level > before), sum(level < before) FROM (SELECT "
            "participant, level,"
            " lag(level) OVER (PARTITION BY attempts.session ORDER BY attempt) AS before"
            " FROM attempts JOIN seats USING (session, seat)) GROUP BY participant ORDER BY "
            "participant"
        ).fetchall()
    challenge = study["challenge"]
    told = [
        (each["participant"], each["lowest"], each["highest"], each["reached_share"])
        for each in challenge
    ]
    assert told == expected
    assert [(each["participant"], each["up"], each["down"]) for each in challenge] == changes
    assert changes[0][1] > 0
    settings = study["tasks"][0]["settings"]
    assert (settings["attempts"], settings["prompts_per_attempt"]) == ([6], [3])


def test_of_one_participant_nothing_of_the_partner_in_a_pair_is_counted(
    call: Call, tmp_path: Path
) -> None:
    pair = ("simulate", "pairs", "-p", "P01", "-p", "P02", "--user", "average", "--attempts", 3)
    assert call(*pair).code == 0
    fall = ("what=Cramp", "severity=mild", "--on", "2026-03-01")
    assert call("record", "add", "adverse-event", "P02", *fall, "--new").code == 0
    found = call("report", "intervention", "-p", "P01", "--simulated", "--json").json
    with closing(sqlite3.connect(tmp_path / "data" / "sar-tui.db")) as database:
        feedback = database.execute(
            "SELECT feedback, count(*) FROM attempts WHERE seat='A' GROUP BY feedback"
        ).fetchall()
    assert found["participants"] == ["P01"]
    assert [(each["participant"], each["done"]) for each in found["dose"]] == [("P01", 3)]
    assert [each["participant"] for each in found["challenge"]] == ["P01"]
    assert found["feedback"] == dict(feedback)
    assert found["harms"]["events"] == {}
    everyone = call("report", "intervention", "--all", "--simulated", "--json").json
    assert everyone["participants"] == ["P01", "P02"]
    assert sum(everyone["feedback"].values()) == 6
    assert everyone["harms"]["events"] == {"mild": 1}


def changed(previous: int, level: int, reason: str = "success") -> m.LevelChanged:
    return m.LevelChanged(previous=previous, level=level, reason=reason)


def new_goal() -> m.GoalChanged:
    return m.GoalChanged(previous=1000.0, goal=900.0, unit="ms", reason="goal", why="It went well.")


def played(attempt: int, level: int, *, practice: bool = False) -> list[m.Message]:
    ended = m.AttemptEnded(
        attempt=attempt, practice=practice, level=level, metric=None, metric_unit="", accuracy=None,
        correct=0, trials=1, outcome="none", feedback="none", started=0, ended=0,
    )  # fmt: skip
    return [m.AttemptStarted(attempt=attempt, practice=practice, level=level, trials=1), ended]


@pytest.mark.parametrize(
    ("messages", "changes"),
    [
        ([*played(1, 1), changed(1, 2)], []),
        ([*played(1, 1), changed(1, 2), *played(2, 2)], ["up"]),
        ([*played(1, 2), changed(2, 1, "failure"), *played(2, 1)], ["down"]),
        ([*played(1, 1), changed(1, 2), changed(2, 1, "operator"), *played(2, 1)], []),
        ([*played(1, 1), changed(1, 2), changed(2, 5, "operator"), *played(2, 5)], ["by_person"]),
        ([*played(1, 1), changed(1, 2), played(2, 2)[0]], []),
        ([*played(1, 3, practice=True), changed(3, 1), *played(2, 1)], []),
        ([*played(1, 1), new_goal(), *played(2, 1), new_goal()], ["goals"]),
        ([*played(1, 1), played(1, 1)[1], changed(1, 2), *played(2, 2), played(2, 2)[1]], ["up"]),
    ],
    ids=[
        "after the last",
        "up",
        "down",
        "taken back",
        "by hand",
        "left",
        "practice",
        "goal",
        "scored again",
    ],
)
def test_a_change_of_level_counts_once_an_attempt_was_played_at_it(
    messages: list[m.Message], changes: list[str]
) -> None:
    assert list(changes_played(messages)) == changes


def record(**changes: Any) -> Record:
    row = {
        "id": "s1", "task": "keyboard", "mode": "live", "status": "completed", "participant": "P01",
        "partner": None, "parameters": {}, "software": {},
        "started_at": "2026-03-01T09:00:00+00:00", "ended_at": None,
    }  # fmt: skip
    given = {"rows": [row], "results": {"P01": []}, "acts": Acts(), "feedback": {}, "operated": 0}
    return Record(**{**given, "programmes": {}, "events": [], **changes})


def test_a_changed_programme_is_a_modification_with_its_reason() -> None:
    versions = [
        Programme({"threshold": 900.0}, version=1, created_at="2026-03-01T09:00:00+00:00"),
        Programme(
            {"attempts": 10}, version=2, created_at="2026-03-08T09:00:00+00:00", reason="Tired."
        ),
    ]
    (change,) = intervention(record(programmes={("P01", "keyboard"): versions})).programmes
    assert (change.version, change.changed, change.reason) == (
        2,
        {"attempts": 10, "threshold": None},
        "Tired.",
    )


def test_harms_are_counted_and_nothing_asked_is_said_as_such() -> None:
    event = PersonRecord(
        id="e1",
        kind="adverse-event",
        participant="P01",
        at="2026-03-01",
        content={"what": "A fall.", "severity": "mild"},
    )
    found = intervention(record(events=[event]))
    assert found.harms.events == {"mild": 1}
    text = str(sections(found))
    assert "Adverse events: 1 mild." in text
    assert "Nothing is known of pain" in text


def test_a_session_without_attempts_is_reported() -> None:
    found = intervention(record())
    assert (found.adherence, found.reached_share, found.dose) == (None, None, [])
    assert "No attempt was finished." in str(sections(found))


def test_three_tasks_are_named_with_one_and(call: Call) -> None:
    call("simulate", "keyboard", "-p", "P01", "--user", "average", "--attempts", 1)
    call("simulate", "reaching", "-p", "P01", "--user", "average", "--attempts", 1)
    call("simulate", "pairs", "-p", "P01", "-p", "P02", "--user", "average", "--attempts", 1)
    printed = call("report", "intervention", "--all", "--simulated").out
    assert (
        "the tasks “Keyboard reaction”, “Reaching” and “Pairs”: 2 participants, 3 sessions"
        in printed
    )

"""The intervention report on simulated sessions: its figures are those of queries on the tables."""

from pathlib import Path
from typing import Any

import pytest

from sar_tui.model import messages as m
from sar_tui.reports.intervention import Acts, Record, changes_played, intervention
from sar_tui.reports.intervention_words import sections
from sar_tui.store.programmes import Programme
from sar_tui.store.records import Record as PersonRecord
from tests.program import Call
from tests.reports.session_script import has
from tests.store.by_hand import sql

BRIEF = "--attempts 6 --set prompts_per_attempt=3"


@pytest.fixture
def study(call: Call) -> dict[str, Any]:
    """The report on three sessions: two of one person, one of another with an operator."""
    for words in (
        f"keyboard -p P01 --user average --seed 1 {BRIEF}",
        f"keyboard -p P01 --user average --seed 2 {BRIEF} --set start_level=3",
        "reaching -p P02 --user poor --seed 3 --attempts 2 --operator careful",
    ):
        assert call(f"simulate {words}").code == 0
    found: dict[str, Any] = call("report intervention --all --simulated --json").json
    return found


def picked(rows: list[dict[str, Any]], *names: str) -> list[tuple[Any, ...]]:
    return [tuple(row[name] for name in ("participant", *names)) for row in rows]


def test_the_dose_and_the_challenge_are_those_of_the_tables(
    study: dict[str, Any], data: Path
) -> None:
    def by_person(figures: str, of: str = "attempts JOIN seats USING (session, seat)") -> list[Any]:
        query = f"SELECT participant, {figures} FROM {of} GROUP BY participant ORDER BY participant"
        return sql(data, query)

    minutes = "round(sum(ended_ns - started_ns) / 6e10, 2)"
    dose = by_person(f"count(DISTINCT attempts.session), count(*), sum(trials), {minutes}")
    names = ("sessions", "done", "repetitions", "time_on_task_min")
    assert picked(study["dose"], *names) == dose
    assert (study["adherence"], study["operated"]) == (1, 1)
    challenge = by_person("min(level), max(level), round(avg(outcome='success'), 4)")
    assert picked(study["challenge"], "lowest", "highest", "reached_share") == challenge
    before = "lag(level) OVER (PARTITION BY attempts.session ORDER BY attempt) AS before"
    both = f"SELECT participant, level, {before} FROM attempts JOIN seats USING (session, seat)"
    changes = by_person("sum(level > before), sum(level < before)", f"({both})")
    assert picked(study["challenge"], "up", "down") == changes
    assert changes[0][1] > 0
    settings = study["tasks"][0]["settings"]
    assert (settings["attempts"], settings["prompts_per_attempt"]) == ([6], [3])


def test_of_one_participant_nothing_of_a_partner_is_counted(call: Call, data: Path) -> None:
    assert call("simulate pairs -p P01 -p P02 --user average --attempts 3").code == 0
    fall = "P02 what=Cramp severity=mild --on 2026-03-01 --new"
    assert call(f"record add adverse-event {fall}").code == 0
    found = call("report intervention -p P01 --simulated --json").json
    query = "SELECT feedback, count(*) FROM attempts WHERE seat='A' GROUP BY feedback"
    assert found["participants"] == ["P01"]
    assert picked(found["dose"], "done") == [("P01", 3)]
    assert picked(found["challenge"]) == [("P01",)]
    assert found["feedback"] == dict(sql(data, query))
    assert found["harms"]["events"] == {}
    everyone = call("report intervention --all --simulated --json").json
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


CHANGES: dict[str, tuple[list[m.Message], list[str]]] = {
    "after the last": ([*played(1, 1), changed(1, 2)], []),
    "up": ([*played(1, 1), changed(1, 2), *played(2, 2)], ["up"]),
    "down": ([*played(1, 2), changed(2, 1, "failure"), *played(2, 1)], ["down"]),
    "taken back": ([*played(1, 1), changed(1, 2), changed(2, 1, "operator"), *played(2, 1)], []),
    "by hand": ([*played(1, 1), changed(1, 2), changed(2, 5, "operator"), *played(2, 5)], ["by_person"]),
    "left": ([*played(1, 1), changed(1, 2), played(2, 2)[0]], []),
    "practice": ([*played(1, 3, practice=True), changed(3, 1), *played(2, 1)], []),
    "goal": ([*played(1, 1), new_goal(), *played(2, 1), new_goal()], ["goals"]),
    "scored again": ([*played(1, 1), played(1, 1)[1], changed(1, 2), *played(2, 2), played(2, 2)[1]], ["up"]),
}  # fmt: skip


@pytest.mark.parametrize("case", CHANGES)
def test_a_change_of_level_counts_once_an_attempt_was_played_at_it(case: str) -> None:
    messages, changes = CHANGES[case]
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
    first, second = "2026-03-01T09:00:00+00:00", "2026-03-08T09:00:00+00:00"
    versions = [
        Programme({"threshold": 900.0}, version=1, created_at=first),
        Programme({"attempts": 10}, version=2, created_at=second, reason="Tired."),
    ]
    (change,) = intervention(record(programmes={("P01", "keyboard"): versions})).programmes
    has(change, version=2, changed={"attempts": 10, "threshold": None}, reason="Tired.")


def test_harms_are_counted_and_nothing_asked_or_done_is_said_as_such() -> None:
    content = {"what": "A fall.", "severity": "mild"}
    who = {"id": "e1", "kind": "adverse-event", "participant": "P01"}
    event = PersonRecord(**who, at="2026-03-01", content=content)
    found = intervention(record(events=[event]))
    assert found.harms.events == {"mild": 1}
    assert (found.adherence, found.reached_share, found.dose) == (None, None, [])
    said = str(sections(found))
    for part in ("Adverse events: 1 mild.", "Nothing is known of pain", "No attempt was finished."):
        assert part in said


def test_three_tasks_are_named_with_one_and(call: Call) -> None:
    for words in ("keyboard -p P01", "reaching -p P01", "pairs -p P01 -p P02"):
        call(f"simulate {words} --user average --attempts 1")
    printed = call("report intervention --all --simulated").out
    tasks = "the tasks “Keyboard reaction”, “Reaching” and “Pairs”"
    assert f"{tasks}: 2 participants, 3 sessions" in printed

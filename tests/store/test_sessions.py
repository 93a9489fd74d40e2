"""Sessions are found, listed and read as they were stored."""

import tempfile
from contextlib import closing
from pathlib import Path
from sqlite3 import Connection
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop.task import Task
from sar_tui.model.trial_types import Metric
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import TaskParameters, build
from sar_tui.store import sessions
from sar_tui.store.database import StoreError, connect
from sar_tui.store.locks import hold
from sar_tui.store.training_days import utc
from tests.examples import examples
from tests.store.by_hand import insert, sql

VERSION = Catalogue().task("keyboard").version


def enter(database: Connection, participant: str = "P01", **more: Any) -> str:
    """Store a new session, and return its id."""
    facts = {"task": "keyboard", "theme": "calm", "seed": 5, "mode": "live", "machine": {},
             "parameters": {"attempts": 3}, "software": {"task": {"version": VERSION}}}  # fmt: skip
    session = sessions.new_id()
    sessions.create(database, session, participant=participant, **(facts | more))
    return session


def listed(database: Connection, data: Path, what: str = "id", **asked: Any) -> list[Any]:
    return [row[what] for row in sessions.listing(database, data, **asked)]


def test_a_new_session_is_a_row_with_its_facts(database: Connection, data: Path) -> None:
    session = enter(database)
    row = sessions.find(database, data, session)
    expected = {"id": session, "task": "keyboard", "theme": "calm", "seed": 5, "mode": "live",
                "participant": "P01", "parameters": {"attempts": 3}, "attempts": 0,
                "ended_at": None}  # fmt: skip
    assert {name: row[name] for name in expected} == expected
    assert row["started_at"].endswith("+00:00")


def test_a_running_session_nobody_holds_was_interrupted(database: Connection, data: Path) -> None:
    session = enter(database)
    with hold(data, "session", session):
        assert listed(database, data, "status") == ["running"]
    assert listed(database, data, "status") == ["interrupted"]


def test_the_newest_session_comes_first(database: Connection, data: Path) -> None:
    entered = [enter(database) for _ in range(5)]
    assert len(set(entered)) == 5
    assert all(len(session) == 10 and session.isalnum() for session in entered)
    assert listed(database, data) == entered[::-1]
    assert listed(database, data, limit=2) == entered[:-3:-1]


def test_a_clock_set_back_does_not_change_the_last_session(
    database: Connection, data: Path
) -> None:
    earlier, last = enter(database, "P01"), enter(database, "P02")
    sql(database, "UPDATE sessions SET started_at='2031-01-01T00:00:00+00:00' WHERE id=?", earlier)
    assert sessions.find(database, data, "last")["id"] == last
    assert listed(database, data) == [last, earlier]
    assert listed(database, data, participant="P01") == [earlier]


def test_an_export_lists_damaged_sessions_and_shares_facts(
    database: Connection, data: Path
) -> None:
    earliest, _, _ = (enter(database) for _ in range(3))
    database.execute("UPDATE sessions SET machine='{broken' WHERE id=?", (earliest,))
    third, second, first = sessions.listing(database, data, also_damaged=True)
    assert (first["machine"], first["software"]) == ({}, third["software"])
    assert second["software"] is third["software"], "thousands of sessions would fill the memory"


def test_a_session_is_found_by_id_beginning_or_as_last(database: Connection, data: Path) -> None:
    with pytest.raises(StoreError, match="There is no session"):
        sessions.find(database, data, "last")
    for id in ("aab0000001", "aac0000002"):
        session = enter(database)
        sql(database, "UPDATE sessions SET id=? WHERE id=?", id, session)
        sql(database, "UPDATE seats SET session=? WHERE session=?", id, session)
    for name, id in {"aab0000001": "aab0000001", "aab": "aab0000001", "last": "aac0000002"}.items():
        assert sessions.find(database, data, name)["id"] == id
    for name, why in {
        "aa": "More than one session begins with aa",
        "x": "There is no session x",
        "": "no session",
        **dict.fromkeys(("%", "_", "' OR 1=1 --"), "There is no session"),
    }.items():
        with pytest.raises(StoreError, match=why) as caught:
            sessions.find(database, data, name)
        assert caught.value.bad_input


def test_each_run_has_its_number_its_anchor_and_its_program(database: Connection) -> None:
    session, other = enter(database), enter(database)
    facts = {"software": {"python": "3"}, "machine": {"flags": ["ssh"]}}
    order = (session, session, other, session)
    assert [sessions.begin_run(database, each, **facts) for each in order] == [1, 2, 1, 3]
    run = sessions.rows(database, "runs", session)[0]
    assert {name: run[name] for name in facts} == facts
    assert set(run["clock_anchor"]) == {"clock_ns", "utc", "utc_offset_s"}
    assert run["pid"] > 0


def test_only_a_running_session_is_marked_as_interrupted(database: Connection, data: Path) -> None:
    done = enter(database)
    sql(database, "UPDATE sessions SET status='completed'")
    for session in (done, enter(database)):
        sessions.interrupt(database, session, utc())
    assert listed(database, data, "status") == ["interrupted", "completed"]


def test_correct_is_a_count_in_attempts_and_a_bool_in_trials(database: Connection) -> None:
    insert(database, "attempts", session="s", correct=1, trials=1)
    insert(database, "trials", session="s", correct=1, timing="{}")
    (attempt,) = sessions.rows(database, "attempts", "s")
    (trial,) = sessions.rows(database, "trials", "s")
    assert (attempt["practice"], type(attempt["correct"]), attempt["trials"]) == (False, int, 1)
    assert (trial["correct"], trial["timing"], trial["details"]) == (True, {}, None)
    assert trial["correct"] is True


# --- earlier best results

TIME, TAPS = Metric("time", "ms", "lower"), Metric("taps", "taps/s", "higher")
ROWS = st.lists(
    st.fixed_dictionaries(
        {
            "participant": st.sampled_from(["P01", "P02"]),
            "task": st.sampled_from(["keyboard", "reaching"]),
            "mode": st.sampled_from(["live", "demonstration", "simulated", "replayed"]),
            "level": st.integers(1, 3),
            "metric": st.none() | st.floats(1, 3000),
            "metric_unit": st.sampled_from(["ms", "ms", "taps/s"]),
            "practice": st.booleans(),
        }
    ),
    max_size=12,
)


@examples(25)
@given(ROWS, st.sampled_from([TIME, TAPS]))
def test_the_best_result_is_from_sessions_of_people_by_level_without_practice(
    rows: list[dict[str, Any]], metric: Metric
) -> None:
    mine = {
        "participant": "P01",
        "task": "keyboard",
        "metric_unit": metric.unit,
        "practice": False,
    }
    parameters = TaskParameters()
    task: Any = SimpleNamespace(
        name="keyboard", version=VERSION, metric=metric, parameters=parameters
    )
    with tempfile.TemporaryDirectory() as folder, closing(connect(Path(folder))) as database:
        entered = []
        for number, row in enumerate(rows, 1):
            session = enter(database, row["participant"], task=row["task"], mode=row["mode"])
            entered.append(session)
            result = {name: row[name] for name in ("practice", "level", "metric", "metric_unit")}
            insert(database, "attempts", session=session, attempt=number, **result)
        for without in ("", *entered):
            best: dict[str, float] = {}
            for session, row in zip(entered, rows, strict=True):
                level, value = str(row["level"]), row["metric"]
                counts = row | mine == row and value is not None and session != without
                counts = counts and row["mode"] in ("live", "demonstration")
                if counts and (level not in best or metric.is_better(value, best[level])):
                    best[level] = value
            assert sessions.best(database, "P01", task, without=without) == best


def attempt_of(
    database: Connection, task: Task, metric: float, accuracy: float = 1.0, version: str = VERSION
) -> None:
    """Store an attempt of a session with the settings of a task."""
    parameters, software = msgspec.to_builtins(task.parameters), {"task": {"version": version}}
    session = enter(database, parameters=parameters, software=software)
    result = {"metric": metric, "metric_unit": "ms", "accuracy": accuracy}
    insert(database, "attempts", session=session, level=1, **result)


def test_the_best_result_has_the_keys_accuracy_and_version_of_the_task(
    database: Connection, keyboard: type[Task]
) -> None:
    def with_keys(keys: str, **more: Any) -> Task:
        return keyboard(build(keyboard.Parameters, {"choice_set": keys, **more}))

    for keys, accuracy, metric in (
        ("both hands", 1.0, 900.0),
        ("left hand", 1.0, 500.0),
        ("both hands", 0.4, 300.0),
    ):
        attempt_of(database, with_keys(keys, feedback_form="qualitative"), metric, accuracy)
    # its levels were others
    attempt_of(database, with_keys("both hands"), 300.0, version="1")
    for keys, best in (("both hands", 900.0), ("left hand", 500.0)):
        assert sessions.best(database, "P01", with_keys(keys)) == {"1": best}

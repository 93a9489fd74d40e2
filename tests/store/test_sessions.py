"""Sessions are found, listed and read as they were stored."""

import sqlite3
import tempfile
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sqlite_utils import Database

from sar_tui.loop.task import Task
from sar_tui.loop.topics import ALL
from sar_tui.model.trial_types import Metric
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import TaskParameters, build
from sar_tui.store import sessions
from sar_tui.store.database import StoreError, connect
from sar_tui.store.locks import hold
from tests.examples import examples
from tests.store.by_hand import add_message

VERSION = Catalogue().task("keyboard").version


def enter(database: sqlite3.Connection, participant: str = "P01", **more: Any) -> str:
    facts = {
        "task": "keyboard",
        "theme": "calm",
        "seed": 5,
        "mode": "live",
        "parameters": {"attempts": 3},
    }
    facts |= {"software": {"task": {"version": VERSION}}}
    session = sessions.new_id()
    sessions.create(database, session, participant=participant, machine={}, **(facts | more))
    return session


def test_a_new_session_is_a_row_with_its_facts(database: sqlite3.Connection, data: Path) -> None:
    session = enter(database)
    row = sessions.find(database, data, session)
    assert (row["id"], row["task"], row["theme"], row["seed"], row["mode"]) == (
        session,
        "keyboard",
        "calm",
        5,
        "live",
    )
    assert (row["participant"], row["parameters"], row["attempts"]) == ("P01", {"attempts": 3}, 0)
    assert row["started_at"].endswith("+00:00")
    assert row["ended_at"] is None


def test_ids_are_random_text(database: sqlite3.Connection) -> None:
    ids = {enter(database) for _ in range(50)}
    assert len(ids) == 50
    assert all(len(session) == 10 and session.isalnum() for session in ids)


def test_a_running_session_nobody_holds_was_interrupted(
    database: sqlite3.Connection, data: Path
) -> None:
    session = enter(database)
    lock = hold(data, "session", session)
    assert [row["status"] for row in sessions.listing(database, data)] == ["running"]
    lock.release()
    assert [row["status"] for row in sessions.listing(database, data)] == ["interrupted"]


def test_the_newest_session_comes_first(database: sqlite3.Connection, data: Path) -> None:
    entered = [enter(database) for _ in range(5)]
    assert [row["id"] for row in sessions.listing(database, data)] == entered[::-1]
    assert [row["id"] for row in sessions.listing(database, data, limit=2)] == entered[:-3:-1]


def test_a_clock_that_was_set_back_does_not_change_which_session_is_the_last(
    database: sqlite3.Connection, data: Path
) -> None:
    earlier, last = enter(database, "P01"), enter(database, "P02")
    database.execute(
        "UPDATE sessions SET started_at='2031-01-01T00:00:00+00:00' WHERE id=?", (earlier,)
    )
    assert sessions.find(database, data, "last")["id"] == last
    assert [row["id"] for row in sessions.listing(database, data)] == [last, earlier]


def test_an_export_lists_damaged_sessions_too_and_keeps_equal_facts_once(
    database: sqlite3.Connection, data: Path
) -> None:
    earliest, _, _ = (enter(database) for _ in range(3))
    database.execute("UPDATE sessions SET machine='{broken' WHERE id=?", (earliest,))
    third, second, first = sessions.listing(database, data, also_damaged=True)
    assert (first["machine"], first["software"]) == ({}, third["software"])
    assert second["software"] is third["software"], "thousands of sessions would fill the memory"


def test_the_sessions_of_one_participant_are_theirs_alone(
    database: sqlite3.Connection, data: Path
) -> None:
    mine, _ = enter(database, "P01"), enter(database, "P02")
    assert [row["id"] for row in sessions.listing(database, data, participant="P01")] == [mine]


def test_a_session_is_found_by_its_id_its_beginning_or_as_the_last(
    database: sqlite3.Connection, data: Path
) -> None:
    session = enter(database)
    last = enter(database)
    database.execute("UPDATE sessions SET id='aab0000001' WHERE id=?", (session,))
    database.execute("UPDATE seats SET session='aab0000001' WHERE session=?", (session,))
    database.execute("UPDATE sessions SET id='aac0000002' WHERE id=?", (last,))
    database.execute("UPDATE seats SET session='aac0000002' WHERE session=?", (last,))
    assert sessions.find(database, data, "aab0000001")["id"] == "aab0000001"
    assert sessions.find(database, data, "aab")["id"] == "aab0000001"
    assert sessions.find(database, data, "last")["id"] == "aac0000002"
    for name, why in (
        ("aa", "More than one session begins with aa"),
        ("x", "There is no session x"),
        ("", "no session"),
    ):
        with pytest.raises(StoreError, match=why) as caught:
            sessions.find(database, data, name)
        assert caught.value.bad_input


@pytest.mark.parametrize("name", ["last", "abc", "%", "_", "' OR 1=1 --"])
def test_a_session_that_does_not_exist_is_not_found(
    database: sqlite3.Connection, data: Path, name: str
) -> None:
    with pytest.raises(StoreError, match="There is no session"):
        sessions.find(database, data, name)


def test_each_run_has_its_number_its_anchor_and_its_program(database: sqlite3.Connection) -> None:
    session, other = enter(database), enter(database)
    numbers = [
        sessions.begin_run(database, s, software={"python": "3"}, machine={"flags": ["ssh"]})
        for s in (session, session, other, session)
    ]
    assert numbers == [1, 2, 1, 3]
    run = sessions.rows(database, "runs", session)[0]
    assert (run["software"], run["machine"]) == ({"python": "3"}, {"flags": ["ssh"]})
    assert set(run["clock_anchor"]) == {"clock_ns", "utc", "utc_offset_s"}
    assert run["pid"] > 0


def test_only_a_running_session_is_marked_as_interrupted(
    database: sqlite3.Connection, data: Path
) -> None:
    done = enter(database)
    database.execute("UPDATE sessions SET status='completed'")
    cut = enter(database)
    for session in (done, cut):
        sessions.interrupt(database, session)
    assert {row["id"]: row["status"] for row in sessions.listing(database, data)} == {
        done: "completed",
        cut: "interrupted",
    }


def test_correct_is_a_count_in_attempts_and_a_bool_in_trials(database: sqlite3.Connection) -> None:
    Database(database)["attempts"].insert(
        {"session": "s", "attempt": 1, "seat": "A", "practice": 0, "correct": 1, "trials": 1}
    )
    Database(database)["trials"].insert(
        {"session": "s", "attempt": 1, "trial": 1, "seat": "A", "correct": 1, "timing": "{}"}
    )
    (attempt,) = sessions.rows(database, "attempts", "s")
    (trial,) = sessions.rows(database, "trials", "s")
    assert (attempt["practice"], type(attempt["correct"]), attempt["trials"]) == (False, int, 1)
    assert (trial["correct"], trial["timing"], trial["details"]) == (True, {}, None)
    assert trial["correct"] is True


@pytest.mark.parametrize(
    ("topic", "message"),
    [("input/none", "{}"), ("input/key", "{}"), ("input/key", "not json"), ("input/key", "[1]")],
)
def test_a_message_that_cannot_be_read_is_reported(
    database: sqlite3.Connection, topic: str, message: str
) -> None:
    session = enter(database)
    add_message(database, session, 1, 0, topic, message)
    with pytest.raises(StoreError, match=f"Message 1 of session {session} cannot be read"):
        list(sessions.history(database, session))


# --- earlier best results

TIME, TAPS = Metric("time", "ms", "lower"), Metric("taps", "taps/s", "higher")
ROWS = st.lists(
    st.fixed_dictionaries(
        {
            "participant": st.sampled_from(["P01", "P02"]),
            "task": st.sampled_from(["keyboard", "reaching"]),
            "mode": st.sampled_from(["live", "live", "simulated", "replayed"]),
            "level": st.integers(1, 3),
            "metric": st.none() | st.floats(1, 3000),
            "unit": st.sampled_from(["ms", "ms", "taps/s"]),
            "practice": st.booleans(),
        }
    ),
    max_size=12,
)


@examples(25)
@given(ROWS, st.sampled_from([TIME, TAPS]))
def test_the_best_result_is_from_live_sessions_by_level_without_practice(
    rows: list[dict[str, Any]], metric: Metric
) -> None:
    with tempfile.TemporaryDirectory() as folder:
        database = connect(Path(folder))
        entered = []
        for number, row in enumerate(rows, 1):
            session = enter(database, row["participant"], task=row["task"], mode=row["mode"])
            entered.append(session)
            Database(database)["attempts"].insert(
                {
                    "session": session,
                    "attempt": number,
                    "seat": "A",
                    "practice": row["practice"],
                    "level": row["level"],
                    "metric": row["metric"],
                    "metric_unit": row["unit"],
                }
            )

        def expected(without: str = "") -> dict[str, float]:
            best: dict[str, float] = {}
            for session, row in zip(entered, rows, strict=True):
                level, value = str(row["level"]), row["metric"]
                whose = (row["participant"], row["task"], row["mode"], row["unit"])
                mine = whose == ("P01", "keyboard", "live", metric.unit)
                if mine and not row["practice"] and value is not None and session != without:
                    known = best.get(level)
                    best[level] = (
                        value if known is None or metric.is_better(value, known) else known
                    )
            return best

        task: Any = SimpleNamespace(
            name="keyboard", version=VERSION, metric=metric, parameters=TaskParameters()
        )
        assert sessions.best(database, "P01", task) == expected()
        for session in entered:
            assert sessions.best(database, "P01", task, without=session) == expected(
                without=session
            )
        database.close()


def test_the_best_result_excludes_other_keys_and_low_accuracy(
    database: sqlite3.Connection, keyboard: type[Task]
) -> None:
    done = [("both hands", 1.0, 900.0), ("left hand", 1.0, 500.0), ("both hands", 0.4, 300.0)]
    for keys, accuracy, metric in done:
        parameters = build(
            keyboard.Parameters, {"choice_set": keys, "feedback_form": "qualitative"}
        )
        row = {
            "session": enter(database, parameters=msgspec.to_builtins(parameters)),
            "attempt": 1,
            "seat": "A",
        }
        row |= {
            "practice": 0,
            "level": 1,
            "metric": metric,
            "metric_unit": "ms",
            "accuracy": accuracy,
        }
        Database(database)["attempts"].insert(row)
    for keys, best in (("both hands", 900.0), ("left hand", 500.0)):
        task = keyboard(build(keyboard.Parameters, {"choice_set": keys}))
        assert sessions.best(database, "P01", task) == {"1": best}


def test_the_best_result_excludes_earlier_versions_of_the_task_whose_levels_were_others(
    database: sqlite3.Connection, keyboard: type[Task]
) -> None:
    task = keyboard(build(keyboard.Parameters, {}))
    for version, metric in (("1", 300.0), (keyboard.version, 700.0)):
        stored = {
            "parameters": msgspec.to_builtins(task.parameters),
            "software": {"task": {"version": version}},
        }
        row = {
            "session": enter(database, **stored),
            "attempt": 1,
            "seat": "A",
            "practice": 0,
            "level": 1,
        }
        Database(database)["attempts"].insert(
            row | {"metric": metric, "metric_unit": "ms", "accuracy": 1.0}
        )
    assert sessions.best(database, "P01", task) == {"1": 700.0}


def test_every_topic_can_be_found_by_its_name() -> None:
    assert all(name == topic.name for name, topic in ALL.items())
    assert {"framework/fault", "input/key", "store/stored"} <= set(ALL)

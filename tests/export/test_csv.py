"""Sessions leave as CSV files that hold what the database holds, to the last digit."""

import json
import math
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import frictionless
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.framework.messages import FeedbackChoice
from sar_tui.framework.messages.loop import Timing
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import connect
from sar_tui.store.selection import Request
from tests.examples import examples
from tests.export.exported import export_csv, read_csv
from tests.program import Call

PLAIN = (
    "session", "attempt", "trial", "seat", "run", "stimulus", "response", "correct", "onset_ns", "response_ns",
    "reaction_time_ms",
)  # fmt: skip


def stored_trials(data: Path) -> list[dict[str, Any]]:
    """Return all trials as the program reads them, sorted by their key, an empty text as missing."""
    with closing(connect(data)) as database:
        ids = [id for (id,) in database.execute("SELECT id FROM sessions")]
        rows = [row for id in ids for row in sessions.rows(database, "trials", id)]
    return sorted(rows, key=lambda row: (row["session"], row["attempt"], row["trial"], row["seat"]))


def assert_equal_to_the_database(data: Path, folder: Path) -> None:
    written = sorted(
        read_csv(folder, "trials"), key=lambda row: (row["session"], row["attempt"], row["trial"], row["seat"])
    )
    expected = stored_trials(data)
    assert len(written) == len(expected)
    for row, stored in zip(written, expected, strict=True):
        assert {name: row[name] for name in PLAIN} == {name: _or_none(stored[name]) for name in PLAIN}
        timing, details = stored["timing"] or {}, stored["details"] or {}
        flags = " ".join(timing.get("flags", ())) or None
        known = {name: _or_none(value) for name, value in timing.items() if name != "flags"}
        assert {name: row[name] for name in known} | {"flags": row["flags"]} == known | {"flags": flags}
        told = {f"details_{name}": _or_none(value) for name, value in details.items()}
        assert {name: row[name] for name in told} == told
        assert all(value is None for name, value in row.items() if name.startswith("details_") and name not in told)


def _or_none(value: object) -> object:
    return None if value == "" else value


SETTINGS = {
    "keyboard": st.fixed_dictionaries(
        {
            "attempts": st.integers(1, 2),
            "prompts_per_attempt": st.integers(1, 6),
            "response_timeout_ms": st.sampled_from([700, 5000]),
            "feedback_schedule": st.sampled_from(["every", "summary", "none"]),
        }
    ),
    "reaching": st.fixed_dictionaries({"attempts": st.just(1), "reaches_per_attempt": st.integers(1, 2)}),
    "pairs": st.fixed_dictionaries(
        {"attempts": st.just(1), "policy": st.sampled_from(["alternate", "race", "cooperative", "joint attention"])}
    ),
}


@given(
    played=st.lists(
        st.sampled_from(sorted(SETTINGS)).flatmap(lambda task: st.tuples(st.just(task), SETTINGS[task])),
        min_size=1,
        max_size=3,
    ),
    seed=st.integers(0, 2**31),
    user=st.sampled_from(sorted(PEOPLE)),
)
@examples(20)
def test_exported_trials_equal_the_database(
    tmp_path_factory: Any, catalogue: Catalogue, played: list[tuple[str, dict[str, object]]], seed: int, user: str
) -> None:
    place = tmp_path_factory.mktemp("played")
    for number, (task, settings) in enumerate(played):
        plan = make_plan(catalogue, task, [f"P{number}"], settings, seed=seed + number, mode="simulated")
        simulate(plan, PEOPLE[user], place / "data", catalogue)
    export_csv(place / "data", place / "out")
    assert_equal_to_the_database(place / "data", place / "out")


TEXT = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=8) | st.sampled_from(
    ['"', 'a "b", c', "¿Qué\r\ntal?", "\r", "\n", ",", ";", "=1+1", " ", "'", "NA", "null", "ñ, á", "\u2028", "true"]
)
REAL = st.none() | st.floats(allow_nan=False, allow_infinity=True) | st.sampled_from([0.1 + 0.2, 5e-324, 1e22, -0.0])
WHOLE = st.integers(-(2**63), 2**63 - 1)
TRIAL = st.fixed_dictionaries(
    {
        "stimulus": TEXT,
        "response": st.none() | TEXT,
        "correct": st.sampled_from([0, 1]),
        "onset_ns": st.none() | WHOLE,
        "response_ns": st.none() | WHOLE,
        "reaction_time_ms": REAL,
        "details": st.none()
        | st.just("null")
        | st.fixed_dictionaries(
            {"choices": st.integers(1, 9), "key_gap_ms": st.none() | st.floats(allow_nan=False, allow_infinity=False)}
        ).map(json.dumps),
    }
)


@given(rows=st.lists(TRIAL, max_size=5))
@examples(200)
def test_odd_texts_and_numbers_leave_as_they_are(tmp_path_factory: Any, rows: list[dict[str, Any]]) -> None:
    place = tmp_path_factory.mktemp("odd")
    _store(place / "data", rows)
    export_csv(place / "data", place / "out")
    for row in rows:
        if row["reaction_time_ms"] is not None and not math.isfinite(row["reaction_time_ms"]):
            row["reaction_time_ms"] = None  # of an earlier version, and read as no result
    assert_equal_to_the_database(place / "data", place / "out")
    assert [row["stimulus"] for row in read_csv(place / "out", "trials")] == [row["stimulus"] or None for row in rows]


def _store(data: Path, rows: list[dict[str, Any]]) -> None:
    """Store a session with these trials, which was cut off in its first attempt."""
    with closing(connect(data)) as database:
        sessions.create(
            database, "s1", task="keyboard", theme="calm", participant="P01", seed=1,
            parameters={}, software={"sar_tui": "0"}, machine={}, mode="live",
        )  # fmt: skip
        for number, row in enumerate(rows, 1):
            values = {"session": "s1", "attempt": 1, "trial": number, "seat": "A", "run": 1, "timing": "{}", **row}
            database.execute(
                f"INSERT INTO trials ({', '.join(values)}) VALUES ({', '.join('?' * len(values))})",
                tuple(values.values()),
            )


def test_the_files_are_what_their_description_says(call: Call, tmp_path: Path) -> None:
    for task in ("keyboard", "reaching", "pairs"):
        call("simulate", task, "--user", "poor", "--attempts", 1, "--seed", 3, "--operator", "careful")
    with closing(connect(tmp_path / "data")) as database:
        database.execute("UPDATE trials SET stimulus=?, response=NULL WHERE trial=2", ('¿"Sí"?\r\nno, no',))
        database.execute("UPDATE attempts SET metric=9e999 WHERE attempt=1")
        note = 'Dice: "me duele",\r\ny descansa; ñ'
        database.execute("INSERT INTO notes SELECT id, 1, 'operator.ana', ?, 'pausa' FROM sessions", (note,))
    _store(tmp_path / "data", [{"stimulus": "f", "details": None}])
    folder = tmp_path / "out"
    export_csv(tmp_path / "data", folder, with_notes=True, with_events=True)
    found = frictionless.validate(str(folder / "datapackage.json"))
    assert found.flatten(["name", "type", "note", "rowNumber", "fieldName"]) == []
    assert len(found.tasks) == 17
    assert {row["text"] for row in read_csv(folder, "notes") if row["label"] == "pausa"} == {note}
    assert {row["decided_by"] for row in read_csv(folder, "actions")} >= {"agent", "operator"}
    assert any(row["state"] == "gap" for row in read_csv(folder, "sensor_faults"))


def test_every_field_of_the_timing_and_of_a_choice_has_a_column(call: Call, simulated: str, tmp_path: Path) -> None:
    export_csv(tmp_path / "data", tmp_path / "out")
    (trial, *_), (attempt, *_) = read_csv(tmp_path / "out", "trials"), read_csv(tmp_path / "out", "attempts")
    assert set(Timing.__struct_fields__) - set(trial) == set()
    assert {f"choice_{name}" for name in FeedbackChoice.__struct_fields__} - set(attempt) == set()


def test_a_task_that_is_not_installed_leaves_with_numbers_but_without_texts_that_nobody_declared(
    call: Call, simulated: str, tmp_path: Path
) -> None:
    with closing(connect(tmp_path / "data")) as database:
        database.execute("UPDATE sessions SET task='gone'")
        database.execute(
            "UPDATE trials SET details=json_set(details, '$.remark', 'Ana is tired', '$.good', json('true'))"
        )
    exported = export_csv(tmp_path / "data", tmp_path / "out")
    rows, stored = read_csv(tmp_path / "out", "trials"), stored_trials(tmp_path / "data")
    assert {row["details_choices"] for row in rows} == {row["details"]["choices"] for row in stored}
    assert {row["details_good"] for row in rows} == {True}
    assert "details_remark" not in rows[0]
    assert "trials.details_remark" in exported.left_out


def test_a_session_without_a_trial_leaves_with_an_empty_table(tmp_path: Path) -> None:
    _store(tmp_path / "data", [])
    export_csv(tmp_path / "data", tmp_path / "out", Request(names=("last",)))
    assert read_csv(tmp_path / "out", "trials") == []
    (row,) = read_csv(tmp_path / "out", "sessions")
    assert (row["session"], row["status"], row["participant"]) == ("s1", "interrupted", "P01")
    assert frictionless.validate(str(tmp_path / "out" / "datapackage.json")).valid


def test_the_mean_reaction_time_is_the_databases(call: Call, simulated: str, tmp_path: Path) -> None:
    export_csv(tmp_path / "data", tmp_path / "out")
    with closing(sqlite3.connect(tmp_path / "data" / "sar-tui.db")) as database:
        stored = [
            time for (time,) in database.execute("SELECT reaction_time_ms FROM trials WHERE correct ORDER BY rowid")
        ]
    written = [row["reaction_time_ms"] for row in read_csv(tmp_path / "out", "trials") if row["correct"]]
    assert sum(written) / len(written) == sum(stored) / len(stored)

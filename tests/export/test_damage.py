"""Damaged values in the database are named, and everything else leaves."""

import json
import re
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.export.registry import BUNDLED
from sar_tui.store.database import connect
from tests.export.exported import csv_of, export_csv, read_csv
from tests.export.hard_study import store_study
from tests.played import simulated
from tests.program import Call
from tests.recorded import told
from tests.store.by_hand import insert, sql, value


def cut(data: Path, where: str, *values: str) -> None:
    """Change rows, of which there must be some."""
    assert sql(data, f"UPDATE {where} RETURNING 1", *values), "something is changed"


BROKEN = "{broken"
JSON_COLUMNS = {
    "trials": ("timing", "details"),
    "attempts": ("choice", "qualities"),
    "actions": ("proposed", "final"),
    "runs": ("clock_anchor", "software"),
    "sessions": ("parameters", "software", "machine"),
    "programmes": ("parameters",),
}


@pytest.fixture
def session(tmp_path: Path) -> str:
    return simulated(tmp_path / "data", user="poor", attempts=2)


@pytest.mark.parametrize("format", BUNDLED)
def test_damaged_values_are_named_and_do_not_leave(
    call: Call, session: str, tmp_path: Path, format: str
) -> None:
    data = tmp_path / "data"
    cut(data, "trials SET reaction_time_ms='x', onset_ns='secret' WHERE attempt=2 AND trial=3")
    cut(data, "attempts SET metric='y', started_ns='secret' WHERE attempt=2")
    cut(data, "trials SET details=? WHERE attempt=2 AND trial=3", BROKEN)
    called = call("export --all --simulated --to", tmp_path / "out", "--format", format)
    assert called.code == 1
    trial = f"! trials, session {session}, attempt 2, trial 3, seat A: what is stored in"
    attempt = f"! attempts, session {session}, attempt 2, seat A: what is stored in"
    columns = (*((trial, name) for name in ("onset_ns", "reaction_time_ms", "details")),
               *((attempt, name) for name in ("started_ns", "metric")))  # fmt: skip
    said = {f"{place} {name} is damaged, and left out." for place, name in columns}
    assert set(called.err.splitlines()) == said
    (manifest,) = (tmp_path / "out").rglob("sar-tui-export.json")
    assert {f"! {each}" for each in json.loads(manifest.read_text())["problems"]} == said
    files = [path for path in (tmp_path / "out").rglob("*") if path.is_file()]
    assert [path for path in files if b"secret" in path.read_bytes()] == []


def test_no_damaged_json_stops_an_export(tmp_path: Path) -> None:
    data = tmp_path / "data"
    store_study(data)
    insert(data, "programmes", task="pairs", created_at="2026")
    export_csv(data, tmp_path / "whole")
    columns = [(table, column) for table, found in JSON_COLUMNS.items() for column in found]
    for table, column in columns:
        newest = f"rowid=(SELECT max(rowid) FROM {table})"
        cut(data, f"{table} SET {column}=? WHERE {newest}", BROKEN)
    cut(data, "messages SET message=? WHERE seq=(SELECT max(seq) FROM messages)", BROKEN)
    cut(data, "imu_streams SET layout='{' WHERE stream=1")
    exported = export_csv(data, tmp_path / "out", with_events=True)
    names = {"programmes": "programme_parameters"}
    for table, column in columns:
        place = (
            "parameters"
            if (table, column) == ("sessions", "parameters")
            else names.get(table, table)
        )
        said = re.compile(rf"{place}, .*what is stored in {column} is damaged")
        assert any(map(said.match, exported.problems)), (table, column)
    assert any("The layout of sensor stream 1 of session" in line for line in exported.problems)
    for table in ("trials", "attempts", "actions", "notes", "runs", "sessions", "imu"):
        assert len(read_csv(tmp_path / "out", table)) == len(read_csv(tmp_path / "whole", table))


def test_a_text_that_is_not_utf_8_leaves_as_far_as_it_is_read(session: str, tmp_path: Path) -> None:
    data = tmp_path / "data"
    whole = csv_of(data, "trials")
    cut(data, "trials SET stimulus=CAST(x'66ff' AS TEXT) WHERE attempt=1 AND trial=2")
    cut(data, "sessions SET machine=replace(machine, '\"', CAST(x'ff22' AS TEXT))")
    exported = export_csv(data, tmp_path / "out")
    rows = read_csv(tmp_path / "out", "trials")
    assert rows[1]["stimulus"] == "f\ufffd"
    assert rows[:1] + rows[2:] == whole[:1] + whole[2:]
    of_machine, of_text = exported.problems[-2:]
    assert (
        of_machine
        == f"sessions, session {session}: what is stored in machine is damaged, and left out."
    )
    place = f"trials, session {session}, attempt 1, trial 2, seat A"
    assert of_text.startswith(f"{place}: the text in stimulus is damaged; \ufffd replaces")


def test_a_damaged_message_of_a_sensor_is_named_others_leave(tmp_path: Path) -> None:
    data = tmp_path / "data"
    simulated(data, "reaching", user="poor", attempts=1)
    whole = csv_of(data, "sensor_faults")
    gaps = "topic='input/sensor' AND json_extract(message, '$.state')='gap'"
    number = value(data, f"SELECT max(seq) FROM events WHERE {gaps}")
    cut(data, "messages SET message=? WHERE seq=?", BROKEN, number)
    (said,) = export_csv(data, tmp_path / "out").problems
    assert said.endswith(f"message {number}: what is stored in a message is damaged, and left out.")
    assert len(read_csv(tmp_path / "out", "sensor_faults")) == len(whole) - 1 > 0


def test_answers_before_no_session_leave_with_their_participant(
    session: str, tmp_path: Path
) -> None:
    data = tmp_path / "data"
    code = value(data, "SELECT participant FROM seats")
    with closing(connect(data)) as database:
        told(database, code, "before", "pain", "7")
        told(database, code, "before", "tiredness", "2", session="another")
    assert csv_of(data, "records") == [], "persons never leave with simulated ones"
    cut(data, "sessions SET mode='live'")
    answer, rating = csv_of(data, "records")
    assert (answer["session"], answer["participant"], answer["option"]) == (None, code, "rated")
    assert (rating["field"], rating["value"]) == ("rating", 7)

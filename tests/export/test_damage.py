"""Damaged values in the database are named, and everything else leaves."""

import json
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.store.database import connect
from tests.export.exported import export_csv, read_csv
from tests.export.hard_study import store_study
from tests.program import Call
from tests.recorded import told

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
def session(call: Call) -> str:
    called = call("simulate", "keyboard", "--user", "poor", "--attempts", 2, "--seed", 3, "--json")
    return str(called.json["session"])


def change(data: Path, statement: str, *values: object) -> None:
    with closing(connect(data)) as database:
        assert database.execute(statement, values).rowcount, "something is changed"


def test_a_damaged_value_is_named_and_the_rest_leaves(
    call: Call, session: str, tmp_path: Path
) -> None:
    change(tmp_path / "data", "UPDATE trials SET details=? WHERE attempt=2 AND trial=3", BROKEN)
    called = call("export", session, "--simulated", "--to", tmp_path / "out")
    said = (
        f"trials, session {session}, attempt 2, trial 3, seat A: what is stored in details is "
        "damaged, and left out."
    )
    assert (called.code, called.err.splitlines()) == (1, [f"! {said}"])
    rows = read_csv(tmp_path / "out", "trials")
    assert [row["details_choices"] is None for row in rows].index(True) == 20 + 2
    assert sum(row["details_choices"] is None for row in rows) == 1
    assert rows[22]["reaction_time_ms"]
    assert said in json.loads((tmp_path / "out" / "sar-tui-export.json").read_text())["problems"]


@pytest.mark.parametrize("format", ["csv", "mat", "bids", "psych-ds", "elan", "parquet"])
def test_texts_in_columns_of_numbers_are_named_and_do_not_leave(
    call: Call, session: str, tmp_path: Path, format: str
) -> None:
    data = tmp_path / "data"
    change(
        data,
        "UPDATE trials SET reaction_time_ms='x', onset_ns='secret' WHERE attempt=2 AND trial=3",
    )
    change(data, "UPDATE attempts SET metric='y', started_ns='secret' WHERE attempt=2")
    called = call("export", session, "--simulated", "--to", tmp_path / "out", "--format", format)
    assert called.code == 1
    trial = f"! trials, session {session}, attempt 2, trial 3, seat A: what is stored in"
    attempt = f"! attempts, session {session}, attempt 2, seat A: what is stored in"
    assert set(called.err.splitlines()) == {
        f"{trial} onset_ns is damaged, and left out.",
        f"{trial} reaction_time_ms is damaged, and left out.",
        f"{attempt} started_ns is damaged, and left out.",
        f"{attempt} metric is damaged, and left out.",
    }
    assert not any(
        b"secret" in path.read_bytes() for path in (tmp_path / "out").rglob("*") if path.is_file()
    )


def test_no_damaged_json_stops_an_export(catalogue: Catalogue, tmp_path: Path) -> None:
    data = tmp_path / "data"
    store_study(data, catalogue)
    change(
        data,
        "INSERT INTO programmes (participant, task, version, created_at, author, reason, "
        "parameters, theme, site)"
        " SELECT 'P01', 'pairs', 1, '2026', '', '', '{}', 'calm', ''",
    )
    export_csv(data, tmp_path / "whole")
    for table, columns in JSON_COLUMNS.items():
        for column in columns:
            change(
                data,
                f"UPDATE {table} SET {column}=? WHERE rowid=(SELECT max(rowid) FROM {table})",
                BROKEN,
            )
    change(data, "UPDATE messages SET message=? WHERE seq=(SELECT max(seq) FROM messages)", BROKEN)
    change(data, "UPDATE imu_streams SET layout='{' WHERE stream=1")
    exported = export_csv(data, tmp_path / "out", with_events=True)
    said = "\n".join(exported.problems)
    for table, columns in JSON_COLUMNS.items():
        name = "programme_parameters" if table == "programmes" else table
        for column in columns:
            place = name if (table, column) != ("sessions", "parameters") else "parameters"
            assert any(
                line.startswith(f"{place}, ") and f"what is stored in {column} is damaged" in line
                for line in exported.problems
            ), (table, column)
    assert "The layout of sensor stream 1 of session" in said
    for table in ("trials", "attempts", "actions", "notes", "runs", "sessions", "imu"):
        assert len(read_csv(tmp_path / "out", table)) == len(read_csv(tmp_path / "whole", table))


def test_a_text_whose_bytes_are_not_utf_8_leaves_as_far_as_it_can_be_read(
    session: str, tmp_path: Path
) -> None:
    data = tmp_path / "data"
    export_csv(data, tmp_path / "whole")
    change(data, "UPDATE trials SET stimulus=CAST(x'66ff' AS TEXT) WHERE attempt=1 AND trial=2")
    change(data, "UPDATE sessions SET machine=replace(machine, '\"', CAST(x'ff22' AS TEXT))")
    exported = export_csv(data, tmp_path / "out")
    rows, whole = read_csv(tmp_path / "out", "trials"), read_csv(tmp_path / "whole", "trials")
    assert rows[1]["stimulus"] == "f\ufffd"
    assert rows[:1] + rows[2:] == whole[:1] + whole[2:]
    assert exported.problems[-2:] == [
        f"sessions, session {session}: what is stored in machine is damaged, and left out.",
        f"trials, session {session}, attempt 1, trial 2, seat A: the text in stimulus is damaged; "
        "\ufffd replaces what "
        "cannot be read.",
    ]


def test_a_damaged_message_of_a_sensor_is_named_and_its_other_faults_leave(
    call: Call, tmp_path: Path
) -> None:
    call("simulate", "reaching", "--user", "poor", "--attempts", 1, "--seed", 3)
    data = tmp_path / "data"
    export_csv(data, tmp_path / "whole")
    with closing(connect(data)) as database:
        (number,) = database.execute(
            "SELECT max(seq) FROM events WHERE topic='input/sensor' AND json_extract(message, "
            "'$.state')='gap'"
        ).fetchone()
    change(data, "UPDATE messages SET message=? WHERE seq=?", BROKEN, number)
    exported = export_csv(data, tmp_path / "out")
    assert [sentence.split(", ")[-2:] for sentence in exported.problems] == [
        [f"message {number}: what is stored in a message is damaged", "and left out."]
    ]
    faults, whole = (read_csv(tmp_path / name, "sensor_faults") for name in ("out", "whole"))
    assert len(faults) == len(whole) - 1 > 0


def test_answers_before_a_session_that_never_began_leave_with_their_participant(
    session: str, tmp_path: Path
) -> None:
    with closing(connect(tmp_path / "data")) as database:
        (code,) = database.execute("SELECT participant FROM seats").fetchone()
        told(database, code, "before", "pain", "7")
        told(database, code, "before", "tiredness", "2", session="another")
    export_csv(tmp_path / "data", tmp_path / "simulated")
    assert read_csv(tmp_path / "simulated", "records") == [], (
        "persons answer, and never leave with simulated ones"
    )
    change(tmp_path / "data", "UPDATE sessions SET mode='live'")
    export_csv(tmp_path / "data", tmp_path / "out")
    answer, rating = read_csv(tmp_path / "out", "records")
    assert (answer["session"], answer["participant"], answer["option"]) == (None, code, "rated")
    assert (rating["field"], rating["value"]) == ("rating", 7)

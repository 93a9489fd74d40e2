"""Sessions leave as CSV files, with a description that they keep."""

from pathlib import Path
from statistics import fmean

import frictionless
import pytest

from sar_tui.model.messages import FeedbackChoice
from sar_tui.model.messages.loop import Timing
from sar_tui.store.selection import Request
from tests.export.exported import csv_of, export_csv, read_csv
from tests.export.test_round_trip import stored_trials
from tests.export.varied import NOTE, store_trials, varied
from tests.program import Call
from tests.store.by_hand import sql


@pytest.mark.slow
def test_the_files_are_what_their_description_says(call: Call, tmp_path: Path) -> None:
    varied(tmp_path / "data")
    folder = tmp_path / "out"
    export_csv(tmp_path / "data", folder, with_notes=True, with_events=True)
    found = frictionless.validate(str(folder / "datapackage.json"))
    assert found.flatten(["name", "type", "note", "rowNumber", "fieldName"]) == []
    assert len(found.tasks) == len(list(folder.glob("*.csv"))) > 15
    assert {row["text"] for row in read_csv(folder, "notes") if row["label"] == "pausa"} == {NOTE}
    assert {row["decided_by"] for row in read_csv(folder, "actions")} >= {"agent", "operator"}
    assert any(row["state"] == "gap" for row in read_csv(folder, "sensor_faults"))


def test_every_field_of_timing_and_choice_has_a_column(simulated: str, data: Path) -> None:
    (trial, *_), (attempt, *_) = csv_of(data, "trials"), csv_of(data, "attempts")
    assert set(Timing.__struct_fields__) - set(trial) == set()
    assert {f"choice_{name}" for name in FeedbackChoice.__struct_fields__} - set(attempt) == set()


def test_a_task_that_is_not_installed_leaves_with_numbers_but_without_texts_that_nobody_declared(
    simulated: str, data: Path, tmp_path: Path
) -> None:
    sql(data, "UPDATE sessions SET task='gone'")
    odd = "json_set(details, '$.remark', 'Ana is tired', '$.good', json('true'))"
    sql(data, f"UPDATE trials SET details={odd}")
    exported = export_csv(data, tmp_path / "out")
    rows, stored = read_csv(tmp_path / "out", "trials"), stored_trials(data)
    assert {row["details_choices"] for row in rows} == {row["details"]["choices"] for row in stored}
    assert {row["details_good"] for row in rows} == {True}
    assert "details_remark" not in rows[0]
    assert "trials.details_remark" in exported.left_out


def test_a_session_without_a_trial_leaves_with_an_empty_table(tmp_path: Path) -> None:
    store_trials(tmp_path / "data", [])
    export_csv(tmp_path / "data", tmp_path / "out", Request(names=("last",)))
    assert read_csv(tmp_path / "out", "trials") == []
    (row,) = read_csv(tmp_path / "out", "sessions")
    assert (row["session"], row["status"], row["participant"]) == ("s1", "interrupted", "P01")
    assert frictionless.validate(str(tmp_path / "out" / "datapackage.json")).valid


def test_the_mean_reaction_time_is_the_stored(simulated: str, data: Path) -> None:
    stored = sql(data, "SELECT reaction_time_ms FROM trials WHERE correct ORDER BY rowid")
    rows = [row for row in csv_of(data, "trials") if row["correct"]]
    assert fmean(row["reaction_time_ms"] for row in rows) == fmean(time for (time,) in stored)

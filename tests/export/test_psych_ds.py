"""Sessions leave as a Psych-DS data set that keeps the rules of its specification."""

import csv
import json
from pathlib import Path
from typing import Any

import pytest

from sar_tui.store.selection import Request
from tests.export.exported import ALL, export_as, export_csv
from tests.export.hard_study import NOTE, store_study
from tests.export.psych_ds_rules import complaints


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    data = tmp_path_factory.mktemp("study") / "data"
    store_study(data)
    return data


def export_psych_ds(data: Path, folder: Path, request: Request = ALL, **options: Any) -> None:
    export_as("psych-ds", data, folder, request, **options)


def load(path: Path) -> Any:
    return json.loads(path.read_text())


def test_a_hard_study_keeps_the_rules(study: Path, tmp_path: Path) -> None:
    export_psych_ds(study, tmp_path / "all", with_notes=True, with_events=True)
    export_psych_ds(study, tmp_path / "live", Request(everything=True), recode=tmp_path / "map.csv")
    for place, some in (("all", " (some are simulated)"), ("live", "")):
        assert complaints(tmp_path / place) == []
        described = load(tmp_path / place / "dataset_description.json")
        assert described["name"] == f"Sessions of motor tasks{some}"


def test_the_rows_are_those_of_csv(study: Path, tmp_path: Path) -> None:
    export_csv(study, tmp_path / "csv", with_notes=True)
    export_psych_ds(study, tmp_path / "psych-ds", with_notes=True)
    data = tmp_path / "psych-ds" / "data"
    for table, name in (("trials", "trials"), ("imu_streams", "imuStreams")):
        written = (data / f"description-{name}_data.csv").read_bytes()
        assert written == (tmp_path / "csv" / f"{table}.csv").read_bytes()
    with (data / "description-notes_data.csv").open(encoding="utf-8", newline="") as file:
        assert NOTE in {row["text"] for row in csv.DictReader(file)}


def test_every_column_has_its_meaning_and_unit(study: Path, tmp_path: Path) -> None:
    export_psych_ds(study, tmp_path / "out")
    known = load(tmp_path / "out" / "dataset_description.json")["variableMeasured"]
    beside = load(tmp_path / "out" / "data" / "description-trials_data.json")["variableMeasured"]
    names = [each["name"] for each in known]
    assert len(set(names)) == len(names)
    columns = {each["name"]: each for each in (*known, *beside)}
    run = next(each for each in known if each["name"] == "run")
    assert "In attempts: The run of the program in which it ended." in run["description"]
    time, angle = columns["reaction_time_ms"], columns["details_excursion_deg"]
    assert (time["@type"], time["unitText"], angle["unitText"]) == ("PropertyValue", "ms", "deg")
    assert all(each["description"] for each in (*known, *beside))

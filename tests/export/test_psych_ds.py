"""Sessions leave as a Psych-DS data set that keeps the rules of its specification."""

import csv
import json
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.export.export import Options, export
from sar_tui.export.registry import load
from sar_tui.plugins import Catalogue
from sar_tui.store.database import connect_to_read
from sar_tui.store.selection import Request
from tests.export.exported import ALL, export_csv, no_bar
from tests.export.hard_study import NOTE, store_study
from tests.export.psych_ds_rules import complaints


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    data = tmp_path_factory.mktemp("study") / "data"
    store_study(data, Catalogue())
    return data


def export_psych_ds(data: Path, folder: Path, request: Request = ALL, **options: Any) -> None:
    with closing(connect_to_read(data)) as database:
        export(
            database,
            data,
            Catalogue(),
            request,
            load("psych-ds"),
            folder,
            no_bar,
            Options(**options),
        )


def test_a_hard_study_keeps_the_rules(study: Path, tmp_path: Path) -> None:
    export_psych_ds(study, tmp_path / "all", with_notes=True, with_events=True)
    export_psych_ds(study, tmp_path / "live", Request(everything=True), recode=tmp_path / "map.csv")
    assert complaints(tmp_path / "all") == complaints(tmp_path / "live") == []
    names = [
        json.loads((tmp_path / place / "dataset_description.json").read_text())["name"]
        for place in ("all", "live")
    ]
    assert names == ["Sessions of motor tasks (some are simulated)", "Sessions of motor tasks"]


def test_the_rows_are_those_of_csv(study: Path, tmp_path: Path) -> None:
    export_csv(study, tmp_path / "csv", with_notes=True)
    export_psych_ds(study, tmp_path / "psych-ds", with_notes=True)
    data = tmp_path / "psych-ds" / "data"
    assert (data / "description-trials_data.csv").read_bytes() == (
        tmp_path / "csv" / "trials.csv"
    ).read_bytes()
    assert (data / "description-imuStreams_data.csv").read_bytes() == (
        tmp_path / "csv" / "imu_streams.csv"
    ).read_bytes()
    with (data / "description-notes_data.csv").open(encoding="utf-8", newline="") as file:
        assert NOTE in {row["text"] for row in csv.DictReader(file)}


def test_every_column_has_its_meaning_and_unit(study: Path, tmp_path: Path) -> None:
    export_psych_ds(study, tmp_path / "out")
    all_of_them = json.loads((tmp_path / "out" / "dataset_description.json").read_text())[
        "variableMeasured"
    ]
    names = [each["name"] for each in all_of_them]
    assert len(set(names)) == len(names)
    (run,) = (each for each in all_of_them if each["name"] == "run")
    assert "In attempts: The run of the program in which it ended." in run["description"]
    beside = json.loads((tmp_path / "out" / "data" / "description-trials_data.json").read_text())[
        "variableMeasured"
    ]
    (time,) = (each for each in beside if each["name"] == "reaction_time_ms")
    assert (time["@type"], time["unitText"]) == ("PropertyValue", "ms")
    (angle,) = (each for each in beside if each["name"] == "details_excursion_deg")
    assert angle["unitText"] == "deg"
    assert all(each["description"] for each in (*all_of_them, *beside))


def test_the_rules_find_planted_errors(study: Path, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    export_psych_ds(study, folder)
    (folder / "data" / "description-runs_data.csv").rename(
        folder / "data" / "description-all-runs_data.csv"
    )
    (folder / "data" / "description-trials_data.json").write_text(
        '{"variableMeasured": ["session"]}'
    )
    (folder / "other.txt").write_text("x")
    found = complaints(folder)
    assert "FILENAME_KEYWORD_FORMATTING_ERROR description-all-runs_data.csv" in found
    assert "CSV_COLUMN_MISSING_FROM_METADATA description-trials_data.csv stimulus" in found
    assert "FILE_NOT_CHECKED other.txt" in found

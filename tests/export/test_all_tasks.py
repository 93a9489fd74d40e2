"""Every bundled task leaves in every format, and the format's own validator, or reader, finds no
fault.
"""

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import frictionless
import pympi
import pytest
from pyarrow import parquet

from sar_tui.export.registry import BUNDLED
from sar_tui.rules.parameters import fields
from tests.examples import first
from tests.export import bids_judge, mat_files, psych_ds_rules
from tests.export.exported import export_as, read_csv
from tests.export.test_elan import read_eaf
from tests.played import catalogue, simulated

TASKS = sorted(path.parent.name for path in (Path(__file__).parents[2] / "tasks").glob("*/task.py"))
_SHORT = {"attempts": 1, "prompts_per_attempt": 3, "reaches_per_attempt": 2, "practice_attempts": 0}


def store(data: Path, tasks: list[str]) -> None:
    """Simulate a short session of each task, with an operator."""
    for number, name in enumerate(tasks):
        task = catalogue().task(name)
        declared = {field.name: field for field in fields(task.Parameters)}
        short = {name: value for name, value in _SHORT.items() if name in declared}
        settings: Any = {name: max(n, int(declared[name].ge or 0)) for name, n in short.items()}
        codes = ["P01", "P02"][: len(task(task.Parameters()).seats)]
        simulated(data, name, *codes, user="poor", seed=number, operator="careful", **settings)


def _csv(folder: Path) -> Iterator[str]:
    report = frictionless.validate(str(folder / "datapackage.json"))
    yield from (f"{row[0]}: {row[-1]}" for row in report.flatten(["path", "message"]))


def _bids(folder: Path) -> Iterator[str]:
    yield from (f"{issue.where}: {issue.what}" for issue in bids_judge.complaints(folder))
    yield from _csv(folder / "sourcedata" / "sar-tui")


def _elan(folder: Path) -> Iterator[str]:
    for path in folder.glob("*.eaf"):
        tiers = read_eaf(path)
        read = pympi.Elan.Eaf(str(path))
        if set(read.get_tier_names()) != set(tiers):
            yield f"{path.name}: pympi reads other tiers"
        for name, annotations in tiers.items():
            found = [tuple(each[:3]) for each in read.get_annotation_data_for_tier(name)]
            if sorted(found) != sorted(annotations):
                yield f"{path.name}: pympi reads other annotations in {name}"


def _mat(folder: Path) -> Iterator[str]:
    described = {(line["table"], line["name"]) for line in mat_files.codebook(folder)}
    as_scipy = {tuple(each[:3]) for each in mat_files.with_scipy(folder)}
    for file, table, name in as_scipy:
        if (table, name) not in described:
            yield f"{file}: {table}.{name} is not in the codebook"


def _parquet(folder: Path) -> Iterator[str]:
    for path in folder.rglob("*.parquet"):
        table = parquet.read_table(path, partitioning=None)
        table.validate(full=True)
        for name in {"details", "data", "qualities"} & set(table.column_names):
            for text in table.column(name).to_pylist():
                json.loads(text)
        if any(not (field.metadata or {}).get(b"meaning") for field in table.schema):
            yield f"{path.name}: a column without a meaning"


def _psych_ds(folder: Path) -> Iterator[str]:
    yield from psych_ds_rules.complaints(folder)


VALIDATORS: dict[str, Callable[[Path], Iterator[str]]] = {
    "csv": _csv, "mat": _mat, "elan": _elan, "parquet": _parquet, "bids": _bids,
    "psych-ds": _psych_ds,
}  # fmt: skip


def faults(data: Path, folder: Path, format: str, **options: Any) -> list[str]:
    """Export all sessions, and return what the format's validator finds; nothing may be missing
    either.
    """
    exported = export_as(format, data, folder, with_events=True, **options)
    return [*exported.problems, *exported.notices, *VALIDATORS[format](folder)]


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("all") / "data"
    store(folder, TASKS)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("format", first(1, BUNDLED))
def test_all_tasks_in_one_export_are_valid(data: Path, tmp_path: Path, format: str) -> None:
    assert faults(data, tmp_path / "out", format) == []
    if format == "csv":
        assert sorted(row["task"] for row in read_csv(tmp_path / "out", "sessions")) == TASKS
        trials = read_csv(tmp_path / "out", "trials")
        for name in ("frame_onsets_ns", "tone_onsets_ns"):
            assert any(" " in (row[name] or "") for row in trials), (
                "a list of stamps is among what is validated"
            )


@pytest.mark.slow
@pytest.mark.parametrize("format", BUNDLED)
def test_all_tasks_are_valid_whatever_leaves(data: Path, tmp_path: Path, format: str) -> None:
    assert faults(data, tmp_path / "recoded", format, recode=tmp_path / "map.csv") == []
    assert faults(data, tmp_path / "noted", format, with_notes=True) == []

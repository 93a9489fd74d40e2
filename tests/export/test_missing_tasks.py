"""Sessions of a task that cannot be loaded leave with what the task kept, and the export says what
it lacks.
"""

import json
from pathlib import Path
from typing import Any

import pytest

from sar_tui.export.registry import BUNDLED
from tests.export.exported import export_as, export_csv, read_csv
from tests.played import simulated
from tests.program import Call
from tests.sides_task import TASK
from tests.store.by_hand import sql

_SOURCE = """
from typing import Annotated

import msgspec

from sar_tui.model.trial_types import Details
""" + TASK.replace(
    '    name = "sides"',
    """
    class Details(Details, frozen=True):
        remark: Annotated[str, msgspec.Meta(description="What the task says of the trial.")]

    name = "gone"
""",
)


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """A session of a task that is not here any more, beside one of a task that is."""
    folder = tmp_path / "data"
    gone = simulated(folder, "gonogo", attempts=1)
    simulated(folder, attempts=1)
    kept = {"side": "left", "force": 2.5, "ready": True, "steps": [1, 2], "remark": "too far out"}
    sql(folder, "UPDATE trials SET details=? WHERE session=?", json.dumps(kept), gone)
    without = "task='gone', software=json_remove(software, '$.task.title')"
    sql(folder, f"UPDATE sessions SET {without} WHERE id=?", gone)
    return folder


def rows_of_gone(folder: Path) -> list[dict[str, Any]]:
    return [row for row in read_csv(folder, "trials") if row["task"] == "gone"]


_SAID = (
    "The task gone cannot be loaded, so nothing says what its details are: they leave as they are "
    "stored, except for texts of several words, which somebody may have typed (details_remark). "
    "Give the folder that the task is in with --tasks DIR to have all of them, each with its "
    "meaning, or add --with-notes."
)


def test_details_of_a_missing_task_leave_as_they_are_stored(data: Path, tmp_path: Path) -> None:
    exported = export_csv(data, tmp_path / "out")
    for row in rows_of_gone(tmp_path / "out"):
        found = [row[f"details_{name}"] for name in ("side", "force", "ready", "steps")]
        assert found == ["left", 2.5, True, "[1,2]"]
    assert (exported.notices, exported.problems) == ([_SAID], [])
    package = json.loads((tmp_path / "out" / "datapackage.json").read_text())
    (trials,) = (each for each in package["resources"] if each["name"] == "trials")
    described = {field["name"]: field["description"] for field in trials["schema"]["fields"]}
    assert "the task gone" in described["details_side"]


@pytest.mark.parametrize("format", BUNDLED)
def test_an_export_says_which_declaration_it_lacks(data: Path, tmp_path: Path, format: str) -> None:
    assert export_as(format, data, tmp_path / "out").notices == [_SAID]
    (manifest,) = (tmp_path / "out").rglob("sar-tui-export.json")
    assert json.loads(manifest.read_text())["notices"] == [_SAID]
    for readme in (tmp_path / "out").glob("README.md"):
        assert _SAID in readme.read_text()


def test_all_details_leave_with_texts_or_the_task(call: Call, data: Path, tmp_path: Path) -> None:
    with_notes = export_csv(data, tmp_path / "noted", with_notes=True)
    assert "details_remark" not in with_notes.notices[0]
    for source, folder, said in (
        (_SOURCE, "with", ""),
        ("import nothing_of_this_name", "without", f"! {_SAID}\n"),
    ):
        own = tmp_path / f"{folder}-tasks" / "gone" / "task.py"
        own.parent.mkdir(parents=True)
        own.write_text(source)
        to = ("--to", tmp_path / folder, "--tasks", own.parents[1])
        called = call("export --all --simulated", *to)
        assert (called.code, called.err) == (0, said)
    for folder in ("noted", "with"):
        assert {row["details_remark"] for row in rows_of_gone(tmp_path / folder)} == {"too far out"}


def test_a_detail_an_installed_task_does_not_declare_is_text(data: Path, tmp_path: Path) -> None:
    sql(data, "UPDATE trials SET details=json_set(details, '$.side', 'left', '$.told', 'ouch')")
    exported = export_csv(data, tmp_path / "out")
    assert {"trials.details_side", "trials.details_told"} <= set(exported.left_out)


def test_settings_that_all_tasks_have_leave_for_a_missing_one(data: Path, tmp_path: Path) -> None:
    export_csv(data, tmp_path / "out")
    here = {row["session"]: row["task"] for row in read_csv(tmp_path / "out", "sessions")}
    (schedule,) = (
        row
        for row in read_csv(tmp_path / "out", "parameters")
        if (here[row["session"]], row["parameter"]) == ("gone", "feedback_schedule")
    )
    assert (schedule["value"], bool(schedule["title"])) == ("every", True)

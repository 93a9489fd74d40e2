"""Sessions of a task that cannot be loaded leave with what the task kept, and the export says what
it lacks.
"""

import json
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.store.database import connect
from tests.export.exported import export_as, export_csv, read_csv
from tests.program import Call

_SOURCE = """
from typing import Annotated

import msgspec

from sar_tui.loop.task import Task
from sar_tui.model.trial_types import Details, Metric


class Gone(Task):
    name = "gone"
    title = "Gone"
    summary = "A task of somebody else."
    metric = Metric("reaction_time", unit="ms", better="lower")

    class Details(Details, frozen=True):
        side: Annotated[str, msgspec.Meta(description="The side that was named.")]
        remark: Annotated[str, msgspec.Meta(description="What the task says of the trial.")]

    def instructions(self):
        return "Press the key."

    def goal(self, level):
        return "As fast as you can."

    def stimulus(self, situation):
        raise NotImplementedError

    def perceived(self, trial, percept):
        raise NotImplementedError
"""


@pytest.fixture
def data(call: Call, tmp_path: Path) -> Path:
    """A session of a task that is not here any more, beside one of a task that is."""
    for task in ("gonogo", "keyboard"):
        call("simulate", task, "--user", "average", "--attempts", 1, "-p", "P01", "--seed", 3)
    with closing(connect(tmp_path / "data")) as database:
        kept = json.dumps(
            {"side": "left", "force": 2.5, "ready": True, "steps": [1, 2], "remark": "too far out"}
        )
        database.execute(
            "UPDATE trials SET details=? WHERE session=(SELECT id FROM sessions WHERE "
            "task='gonogo')",
            (kept,),
        )
        database.execute("UPDATE sessions SET task='gone', software=json_remove(software, '$.task.title')"
                         " WHERE task='gonogo'")  # fmt: skip
    return tmp_path / "data"


_SAID = (
    "The task gone cannot be loaded, so nothing says what its details are: they leave as they are "
    "stored, except for "
    "texts of several words, which somebody may have typed (details_remark). Give the folder that "
    "the task is in with "
    "--tasks DIR to have all of them, each with its meaning, or add --with-notes."
)


def test_details_of_a_task_that_cannot_be_loaded_leave_as_they_are_stored(
    data: Path, tmp_path: Path
) -> None:
    exported = export_csv(data, tmp_path / "out")
    rows = [row for row in read_csv(tmp_path / "out", "trials") if row["task"] == "gone"]
    assert {
        (row["details_side"], row["details_force"], row["details_ready"], row["details_steps"])
        for row in rows
    } == {("left", 2.5, True, "[1,2]")}
    assert (exported.notices, exported.problems) == ([_SAID], [])
    package = json.loads((tmp_path / "out" / "datapackage.json").read_text())
    (fields,) = (
        each["schema"]["fields"] for each in package["resources"] if each["name"] == "trials"
    )
    assert "the task gone" in next(
        field["description"] for field in fields if field["name"] == "details_side"
    )


@pytest.mark.parametrize("format", ["csv", "bids", "psych-ds", "mat", "elan", "parquet"])
def test_an_export_says_which_declaration_it_lacks(data: Path, tmp_path: Path, format: str) -> None:
    assert export_as(format, data, tmp_path / "out").notices == [_SAID]
    (manifest,) = (tmp_path / "out").rglob("sar-tui-export.json")
    assert json.loads(manifest.read_text())["notices"] == [_SAID]
    for readme in (tmp_path / "out").glob("README.md"):
        assert _SAID in readme.read_text()


def test_all_details_leave_with_texts_or_with_the_task(
    call: Call, data: Path, tmp_path: Path
) -> None:
    with_notes = export_csv(data, tmp_path / "noted", with_notes=True)
    assert "details_remark" not in with_notes.notices[0]
    rows = [row for row in read_csv(tmp_path / "noted", "trials") if row["task"] == "gone"]
    assert {row["details_remark"] for row in rows} == {"too far out"}
    (tmp_path / "own" / "gone").mkdir(parents=True)
    (tmp_path / "own" / "gone" / "task.py").write_text(_SOURCE)
    to = ("--all", "--simulated", "--to")
    called = call("export", *to, tmp_path / "with", "--tasks", tmp_path / "own")
    assert (called.code, called.err) == (0, "")
    rows = [row for row in read_csv(tmp_path / "with", "trials") if row["task"] == "gone"]
    assert {row["details_remark"] for row in rows} == {"too far out"}
    called = call("export", *to, tmp_path / "without")
    assert (called.code, called.err) == (0, f"! {_SAID}\n")


def test_a_task_that_fails_to_load_is_named_alike(call: Call, data: Path, tmp_path: Path) -> None:
    (tmp_path / "own" / "gone").mkdir(parents=True)
    (tmp_path / "own" / "gone" / "task.py").write_text("import nothing_of_this_name")
    called = call(
        "export", "--all", "--simulated", "--to", tmp_path / "out", "--tasks", tmp_path / "own"
    )
    assert (called.code, called.err) == (0, f"! {_SAID}\n")


def test_a_detail_that_an_installed_task_does_not_declare_stays_a_text(
    data: Path, tmp_path: Path
) -> None:
    with closing(connect(data)) as database:
        database.execute(
            "UPDATE trials SET details=json_set(details, '$.side', 'left', '$.told', 'ouch')"
        )
    exported = export_csv(data, tmp_path / "out")
    assert {"trials.details_side", "trials.details_told"} <= set(exported.left_out)


def test_settings_that_all_tasks_have_leave_for_a_task_that_cannot_be_loaded(
    data: Path, tmp_path: Path
) -> None:
    export_csv(data, tmp_path / "out")
    here = {row["session"]: row["task"] for row in read_csv(tmp_path / "out", "sessions")}
    rows = [
        row for row in read_csv(tmp_path / "out", "parameters") if here[row["session"]] == "gone"
    ]
    (schedule,) = (row for row in rows if row["parameter"] == "feedback_schedule")
    assert (schedule["value"], bool(schedule["title"])) == ("every", True)

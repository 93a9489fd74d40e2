"""Names, devices, places and typed texts do not leave unless they are asked for, whichever table
they are in.
"""

import gzip
import json
from contextlib import closing
from pathlib import Path

import pyarrow.parquet
import pytest
from sqlite_utils import Database

from sar_tui.export.registry import BUNDLED
from sar_tui.store.database import connect
from tests.export.exported import export_as, export_csv, read_csv
from tests.program import Call
from tests.store.by_hand import add_message

NEVER = "Dr-Anna-Wirth"
"""Stands for the name of an operator, a login, a device, a computer, or a folder."""
TYPED = "she said it hurts"
"""Stands for a text that somebody typed."""


@pytest.fixture
def data(call: Call, tmp_path: Path) -> Path:
    """A database in which every place that may hold such a text holds one."""
    call(
        "simulate",
        "reaching",
        "--user",
        "poor",
        "--attempts",
        1,
        "--seed",
        4,
        "-p",
        "P01",
        "--operator",
        "careful",
    )
    folder = tmp_path / "data"
    with closing(connect(folder)) as database:
        (session,) = database.execute("SELECT id FROM sessions").fetchone()
        update = database.execute
        addresses = {
            "outputs": ["screen", f"ros://{NEVER}"],
            "speech": f"file:/home/{NEVER}",
            "imu": f"x://{NEVER}",
        }
        update("UPDATE sessions SET parameters=json_patch(parameters, ?)", (json.dumps(addresses),))
        update(
            "UPDATE sessions SET parameters=json_set(parameters, '$.own', ?, '$.count', 3)",
            (TYPED,),
        )
        update("UPDATE sessions SET machine=json_set(machine, '$.host', ?)", (NEVER,))
        update("UPDATE runs SET boot_id=?, machine=json_set(machine, '$.host', ?)", (NEVER, NEVER))
        update("UPDATE imu_streams SET serial=?, source=?", (NEVER, f"phidget://{NEVER}"))
        update(
            "UPDATE actions SET actor=?, proposed=json_set(proposed, '$.text', ?)",
            (f"operator.{NEVER}", TYPED),
        )
        report = {
            "action": "a1",
            "output": f"ros://{NEVER}",
            "deed": "say",
            "state": "failed",
            "at": 1,
            "detail": NEVER,
        }
        add_message(database, session, 0, 1, "output/report", report)
        update("UPDATE trials SET details=json_set(details, '$.remark', ?)", (TYPED,))
        tables = Database(database)
        tables["notes"].insert_all(  # type: ignore[union-attr]
            {"session": session, "at_ns": 1, "author": author, "text": TYPED, "label": TYPED}
            for author in (f"operator.{NEVER}", NEVER)
        )
        login, now = (
            {"recorded_by": NEVER, "recorded_at": "2026-01-01T10:00:00+00:00"},
            "2026-01-01T10:00:00+00:00",
        )
        tables["programmes"].insert(  # type: ignore[union-attr]
            {"participant": "P01", "task": "reaching", "version": 1, "created_at": now, "author": NEVER,
             "reason": TYPED, "parameters": json.dumps({"own": TYPED, **addresses}), "theme": "calm"}
        )  # fmt: skip
        contents = (
            ("adverse-event", {"what": TYPED, "severity": "mild", "outcome": TYPED}),
            ("ARAT", {"score": 7, "note": TYPED}),
            ("kind of nobody", {"colour": TYPED}),
        )
        tables["records"].insert_all(  # type: ignore[union-attr]
            {"id": f"e{number}", "version": 1, "kind": kind, "participant": "P01", "seat": "A",
             "moment": "", "at": "2026-01-01", "content": json.dumps(content), **login}
            for number, (kind, content) in enumerate(contents)
        )  # fmt: skip
    return folder


def files(folder: Path) -> dict[str, str]:
    """Return the contents of all files, by name."""
    return {path.name: _text(path) for path in folder.rglob("*") if path.is_file()}


def _text(path: Path) -> str:
    if path.suffix == ".parquet":
        return str(pyarrow.parquet.read_table(path).to_pylist())
    return (gzip.decompress if path.suffix == ".gz" else bytes)(path.read_bytes()).decode(
        errors="replace"
    )


@pytest.mark.parametrize("format", BUNDLED)
def test_nothing_that_identifies_or_was_typed_leaves(
    data: Path, tmp_path: Path, format: str
) -> None:
    exported = export_as(format, data, tmp_path / "out", with_events=True)
    found = files(tmp_path / "out")
    assert [name for name, text in found.items() if NEVER in text] == []
    assert [name for name, text in found.items() if TYPED in text] == []
    assert {"notes.text", "records.words", "trials.details_remark"} <= set(exported.left_out)


@pytest.mark.parametrize("format", BUNDLED)
def test_typed_texts_leave_in_every_format_if_asked_for(
    data: Path, tmp_path: Path, format: str
) -> None:
    export_as(format, data, tmp_path / "out", with_notes=True, with_events=True)
    found = files(tmp_path / "out")
    assert [name for name, text in found.items() if NEVER in text] == []
    assert [name for name, text in found.items() if TYPED in text] != []


def test_typed_texts_leave_if_asked_for_and_names_never(data: Path, tmp_path: Path) -> None:
    export_csv(data, tmp_path / "out", with_notes=True, with_events=True)
    found = files(tmp_path / "out")
    assert [name for name, text in found.items() if NEVER in text] == []
    assert {name for name, text in found.items() if TYPED in text} == {
        "actions.csv", "notes.csv", "parameters.csv", "programmes.csv", "programme_parameters.csv",
        "records.csv", "trials.csv",
    }  # fmt: skip


def test_roles_and_first_words_stand_for_names_and_addresses(data: Path, tmp_path: Path) -> None:
    export_csv(data, tmp_path / "out")
    assert [row["written_by"] for row in read_csv(tmp_path / "out", "notes")][-2:] == [
        "operator",
        "other",
    ]
    values = {row["parameter"]: row["value"] for row in read_csv(tmp_path / "out", "parameters")}
    assert [values[name] for name in ("outputs", "speech", "imu")] == ["screen ros", "file", "x"]
    assert (values["own"], values["count"], values["language"]) == (None, "3", "en")

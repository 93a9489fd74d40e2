"""Names, devices, places and typed texts do not leave unless they are asked for, whichever table
they are in.
"""

import gzip
import json
from contextlib import closing
from pathlib import Path
from typing import Any

import pyarrow.parquet
import pytest

from sar_tui.export.registry import BUNDLED
from sar_tui.store.database import connect
from tests.export.exported import csv_of, export_as
from tests.played import simulated
from tests.store.by_hand import add_message, insert, sql

NEVER = "Dr-Anna-Wirth"
"""Stands for the name of an operator, a login, a device, a computer, or a folder."""
TYPED = "she said it hurts"
"""Stands for a text that somebody typed."""
NOW = "2026-01-01T10:00:00+00:00"


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """A database in which every place that may hold such a text holds one."""
    folder = tmp_path / "data"
    session = simulated(folder, "reaching", user="poor", seed=4, operator="careful", attempts=1)
    addresses = {
        "outputs": ["screen", f"ros://{NEVER}"],
        "speech": f"file:/home/{NEVER}",
        "imu": f"x://{NEVER}",
    }
    report = {"action": "a1", "output": f"ros://{NEVER}", "deed": "say", "state": "failed", "at": 1,
              "detail": NEVER}  # fmt: skip
    texts = {"own": TYPED, "count": 3, **addresses}
    with closing(connect(folder)) as database:
        for table, changes, *values in (
            ("sessions", "parameters=json_patch(parameters, ?)", json.dumps(texts)),
            ("sessions", "machine=json_set(machine, '$.host', ?)", NEVER),
            ("runs", "boot_id=?, machine=json_set(machine, '$.host', ?)", NEVER, NEVER),
            ("imu_streams", "serial=?, source=?", NEVER, f"phidget://{NEVER}"),
            (
                "actions",
                "actor=?, proposed=json_set(proposed, '$.text', ?), final=json_set(final, '$.text', ?)",
                f"operator.{NEVER}",
                TYPED,
                TYPED,
            ),
            ("trials", "details=json_set(details, '$.remark', ?)", TYPED),
        ):
            sql(database, f"UPDATE {table} SET {changes}", *values)
        add_message(database, session, 0, 1, "output/report", report)
        for author in (f"operator.{NEVER}", NEVER):
            note = {"author": author, "text": TYPED, "label": TYPED}
            insert(database, "notes", session=session, at_ns=1, **note)
        own = json.dumps({"own": TYPED, **addresses})
        typed = {"author": NEVER, "reason": TYPED, "parameters": own}
        insert(database, "programmes", task="reaching", created_at=NOW, **typed)
        contents: dict[str, Any] = {
            "adverse-event": {"what": TYPED, "severity": "mild", "outcome": TYPED},
            "ARAT": {"score": 7, "note": TYPED},
            "kind of nobody": {"colour": TYPED},
        }
        for kind, content in contents.items():
            entered = {"at": "2026-01-01", "recorded_by": NEVER, "recorded_at": NOW}
            insert(database, "records", id=kind, kind=kind, content=json.dumps(content), **entered)
    return folder


def holding(text: str, folder: Path) -> list[str]:
    """Return the names of the files that hold a text."""
    files = [path for path in folder.rglob("*") if path.is_file()]
    return sorted(path.name for path in files if text in _text(path))


def _text(path: Path) -> str:
    if path.suffix == ".parquet":
        return str(pyarrow.parquet.read_table(path).to_pylist())
    content = path.read_bytes()
    return (gzip.decompress(content) if path.suffix == ".gz" else content).decode(errors="replace")


@pytest.mark.parametrize("format", BUNDLED)
def test_nothing_identifying_or_typed_leaves(data: Path, tmp_path: Path, format: str) -> None:
    exported = export_as(format, data, tmp_path / "out", with_events=True)
    assert holding(NEVER, tmp_path / "out") == holding(TYPED, tmp_path / "out") == []
    assert {"notes.text", "records.words", "trials.details_remark"} <= set(exported.left_out)


@pytest.mark.parametrize("format", BUNDLED)
def test_typed_texts_leave_in_all_if_asked_for(data: Path, tmp_path: Path, format: str) -> None:
    export_as(format, data, tmp_path / "out", with_notes=True, with_events=True)
    assert holding(NEVER, tmp_path / "out") == []
    found = holding(TYPED, tmp_path / "out")
    assert found
    if format == "csv":
        tables = "actions notes parameters programme_parameters programmes records trials"
        assert found == [f"{table}.csv" for table in tables.split()]


def test_roles_and_first_words_stand_for_names_and_addresses(data: Path) -> None:
    assert [row["written_by"] for row in csv_of(data, "notes")][-2:] == ["operator", "other"]
    values = {row["parameter"]: row["value"] for row in csv_of(data, "parameters")}
    assert [values[name] for name in ("outputs", "speech", "imu")] == ["screen ros", "file", "x"]
    assert (values["own"], values["count"], values["language"]) == (None, "3", "en")

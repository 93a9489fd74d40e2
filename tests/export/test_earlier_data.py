"""Sessions of an earlier version leave as those of this one do."""

import gzip
from pathlib import Path

import frictionless

from tests.export.exported import export_csv, read_csv
from tests.store import test_earlier_data as earlier


def test_earlier_sessions_leave(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    packed = Path(earlier.__file__).with_name("earlier.db.gz").read_bytes()
    (tmp_path / "data" / "sar-tui.db").write_bytes(gzip.decompress(packed))
    exported = export_csv(tmp_path / "data", tmp_path / "out", with_events=True)
    assert (set(exported.sessions), exported.problems) == (set(earlier.ALL), [])
    status = {row["session"]: row["status"] for row in read_csv(tmp_path / "out", "sessions")}
    assert status[earlier.INTERRUPTED] == "interrupted"
    assert {row["session"] for row in read_csv(tmp_path / "out", "trials")} == set(earlier.ALL)
    assert {row["session"] for row in read_csv(tmp_path / "out", "events")} == set(earlier.ALL)
    found = frictionless.validate(str(tmp_path / "out" / "datapackage.json"))
    assert found.flatten(["name", "type", "note"]) == []

"""Beside the data are the timing of the machine and the methods in words."""

import hashlib
import json
from contextlib import closing
from importlib.metadata import version
from pathlib import Path

import pytest

from sar_tui.rules.version import RULES
from sar_tui.store.database import connect
from tests.export.exported import export_csv, read_csv
from tests.program import Call

TIMING = {"measured_at": "2026-03-01T10:00:00+00:00", "median_ms": 0.21, "robust_sd_ms": 0.07, "p99_ms": 0.9,
          "verdict": "fit", "n": 300, "where": "the clinic's back room"}  # fmt: skip


@pytest.fixture
def measured(call: Call, tmp_path: Path) -> str:
    """A session on a machine whose timing was measured, beside one where it was not; its id."""
    call("simulate", "keyboard", "--user", "poor", "--attempts", 1, "-p", "P02")
    (tmp_path / "data" / "timing.json").write_text(json.dumps(TIMING))
    called = call("simulate", "keyboard", "--user", "poor", "--attempts", 3, "-p", "P01", "--json")
    return str(called.json["session"])


def test_a_session_names_the_timing_it_was_recorded_with(measured: str, tmp_path: Path) -> None:
    export_csv(tmp_path / "data", tmp_path / "out")
    (passport,) = json.loads((tmp_path / "out" / "timing.json").read_text())["passports"]
    rows = {row["session"]: row["timing_sha256"] for row in read_csv(tmp_path / "out", "sessions")}
    assert passport["sessions"] == [measured]
    assert passport["timing"] == {name: value for name, value in TIMING.items() if name != "where"}
    canonical = json.dumps(passport["timing"], sort_keys=True, separators=(",", ":"))
    assert (
        passport["sha256"] == hashlib.sha256(canonical.encode()).hexdigest() == rows.pop(measured)
    )
    assert list(rows.values()) == [None]


def test_the_date_of_the_measurement_does_not_leave_with_shifted_dates(
    measured: str, tmp_path: Path
) -> None:
    export_csv(tmp_path / "data", tmp_path / "out", recode=tmp_path / "map.csv")
    assert "2026-03-01" not in (tmp_path / "out" / "timing.json").read_text()
    assert "2026-03-01" not in (tmp_path / "out" / "methods.md").read_text()


def test_methods_are_told_in_words(measured: str, tmp_path: Path) -> None:
    export_csv(tmp_path / "data", tmp_path / "out")
    text = (tmp_path / "out" / "methods.md").read_text()
    assert (
        "2 participants did the task “Keyboard reaction” (version 2) in 2 simulated sessions"
        in text
    )
    assert "Attempts planned in a session: 1 or 3, 20 prompts in each." in text
    assert "The level followed the rule “one-up-one-down”, up to level 20." in text
    assert "median 0.21 ms, robust SD 0.07 ms, 99th percentile 0.90 ms (fit)" in text
    assert "Before 1 session, the error of reaction times had not been measured." in text
    manifest = json.loads((tmp_path / "out" / "sar-tui-export.json").read_text())
    assert {"timing.json", "methods.md"} <= {file["path"] for file in manifest["files"]}


def test_a_record_without_parameters_has_methods_too(measured: str, tmp_path: Path) -> None:
    with closing(connect(tmp_path / "data")) as database:
        database.execute("UPDATE sessions SET parameters='{}', software='{}', machine='{}'")
    export_csv(tmp_path / "data", tmp_path / "out")
    text = (tmp_path / "out" / "methods.md").read_text()
    assert "All that is random follows from the seed" in text
    assert "Sessions ran on a system that is not recorded." in text
    assert "None" not in text


def test_sessions_and_runs_say_by_which_rules_and_numpy_and_in_which_time_zone_they_were_made(
    measured: str, tmp_path: Path
) -> None:
    with closing(connect(tmp_path / "data")) as database:
        database.execute(
            "UPDATE runs SET clock_anchor=json_set(clock_anchor, '$.utc_offset_s', 20700)"
        )
    export_csv(tmp_path / "data", tmp_path / "out")
    for row in read_csv(tmp_path / "out", "sessions"):
        assert (row["loop_rules"], row["numpy"]) == (RULES, version("numpy"))
    for row in read_csv(tmp_path / "out", "runs"):
        assert (row["utc_offset_s"], row["numpy"]) == (20700, version("numpy"))
    export_csv(tmp_path / "data", tmp_path / "recoded", recode=tmp_path / "map.csv")
    assert {row["loop_rules"] for row in read_csv(tmp_path / "recoded", "sessions")} == {RULES}
    assert all(
        "utc_offset_s" not in file.read_text() for file in (tmp_path / "recoded").rglob("*.csv")
    )
    assert (
        "runs.utc_offset_s"
        in json.loads((tmp_path / "recoded" / "sar-tui-export.json").read_text())["left_out"]
    )


def test_a_session_recorded_without_offset_has_none(measured: str, tmp_path: Path) -> None:
    with closing(connect(tmp_path / "data")) as database:
        database.execute("UPDATE runs SET clock_anchor=json_remove(clock_anchor, '$.utc_offset_s')")
    export_csv(tmp_path / "data", tmp_path / "out")
    assert {row["utc_offset_s"] for row in read_csv(tmp_path / "out", "runs")} == {None}

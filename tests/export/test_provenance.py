"""Beside the data are the timing of the machine and the methods in words."""

import hashlib
import json
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

from sar_tui.loop.session import RULES
from tests.export.exported import csv_of, export_csv, read_csv
from tests.played import simulated
from tests.store.by_hand import sql

TIMING = {"measured_at": "2026-03-01T10:00:00+00:00", "median_ms": 0.21, "robust_sd_ms": 0.07, "p99_ms": 0.9,
          "verdict": "fit", "n": 300, "where": "the clinic's back room"}  # fmt: skip


@pytest.fixture
def measured(tmp_path: Path) -> str:
    """A session on a machine whose timing was measured, beside one where it was not; its id."""
    data = tmp_path / "data"
    simulated(data, "keyboard", "P02", user="poor", attempts=1)
    (data / "timing.json").write_text(json.dumps(TIMING))
    return simulated(data, user="poor", attempts=3)


def test_a_session_names_the_timing_it_was_recorded_with(measured: str, tmp_path: Path) -> None:
    export_csv(tmp_path / "data", tmp_path / "out")
    (passport,) = json.loads((tmp_path / "out" / "timing.json").read_text())["passports"]
    rows = {row["session"]: row["timing_sha256"] for row in read_csv(tmp_path / "out", "sessions")}
    assert passport["sessions"] == [measured]
    assert passport["timing"] == {name: each for name, each in TIMING.items() if name != "where"}
    canonical = json.dumps(passport["timing"], sort_keys=True, separators=(",", ":"))
    hashed = hashlib.sha256(canonical.encode()).hexdigest()
    assert passport["sha256"] == hashed == rows.pop(measured)
    assert list(rows.values()) == [None]


def methods(tmp_path: Path, **options: Any) -> str:
    """Export all sessions, and return the methods in words."""
    export_csv(tmp_path / "data", tmp_path / "out", **options)
    return (tmp_path / "out" / "methods.md").read_text()


def test_the_date_of_the_measurement_leaves_with_no_recoded(measured: str, tmp_path: Path) -> None:
    assert "2026-03-01" not in methods(tmp_path, recode=tmp_path / "map.csv")
    assert "2026-03-01" not in (tmp_path / "out" / "timing.json").read_text()


def test_methods_are_told_in_words(measured: str, tmp_path: Path) -> None:
    text = methods(tmp_path)
    for said in (
        "2 participants did the task “Keyboard reaction” (version 2) in 2 simulated sessions",
        "Attempts planned in a session: 1 or 3, 20 prompts in each.",
        "The level followed the rule “one-up-one-down”, up to level 20.",
        "median 0.21 ms, robust SD 0.07 ms, 99th percentile 0.90 ms (fit)",
        "Before 1 session, the error of reaction times had not been measured.",
    ):
        assert said in text
    manifest = json.loads((tmp_path / "out" / "sar-tui-export.json").read_text())
    assert {"timing.json", "methods.md"} <= {file["path"] for file in manifest["files"]}


def test_methods_tell_of_switches_and_of_slow_keys(measured: str, tmp_path: Path) -> None:
    change = "json_set(parameters, '$.switch', 'one', '$.added_delay_ms', 300)"
    sql(tmp_path / "data", f"UPDATE sessions SET parameters={change}")
    text = methods(tmp_path)
    assert "2 sessions used one-switch scanning" in text
    assert "slow keys added 300 ms to each press" in text


def test_methods_tell_of_no_slow_keys_where_nobody_has_any(measured: str, tmp_path: Path) -> None:
    change = "json_set(parameters, '$.system_keys', 'neither', '$.added_delay_ms', 0)"
    sql(tmp_path / "data", f"UPDATE sessions SET parameters={change}")
    assert "slow keys" not in methods(tmp_path)


def test_a_record_without_parameters_has_methods_too(measured: str, tmp_path: Path) -> None:
    sql(tmp_path / "data", "UPDATE sessions SET parameters='{}', software='{}', machine='{}'")
    text = methods(tmp_path)
    assert "All that is random follows from the seed" in text
    assert "Sessions ran on a system that is not recorded." in text
    assert "None" not in text


def test_sessions_and_runs_say_by_which_rules_and_numpy_and_in_which_time_zone_they_were_made(
    measured: str, tmp_path: Path
) -> None:
    data, out, numpy = tmp_path / "data", tmp_path / "recoded", version("numpy")
    sql(data, "UPDATE runs SET clock_anchor=json_set(clock_anchor, '$.utc_offset_s', 20700)")
    for row in csv_of(data, "sessions"):
        assert (row["loop_rules"], row["numpy"]) == (RULES, numpy)
    for row in csv_of(data, "runs"):
        assert (row["utc_offset_s"], row["numpy"]) == (20700, numpy)
    export_csv(data, out, recode=tmp_path / "map.csv")
    assert {row["loop_rules"] for row in read_csv(out, "sessions")} == {RULES}
    assert [path for path in out.rglob("*.csv") if "utc_offset_s" in path.read_text()] == []
    manifest = json.loads((out / "sar-tui-export.json").read_text())
    assert "runs.utc_offset_s" in manifest["left_out"]
    sql(data, "UPDATE runs SET clock_anchor=json_remove(clock_anchor, '$.utc_offset_s')")
    assert {row["utc_offset_s"] for row in csv_of(data, "runs")} == {None}

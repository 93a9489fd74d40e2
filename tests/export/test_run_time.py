"""Stamps in a recoded export count from the start of their run, and what cannot be of that run does
not leave.
"""

from pathlib import Path
from typing import Any

import pytest

from sar_tui.export.run_time import RunStarts, without_dates
from tests.export.exported import export_csv, read_csv
from tests.export.resumed import resumed

DAY = 86_400
START = 40 * DAY * 10**9
STARTS = RunStarts({1: START, 2: 5}, {})


@pytest.mark.parametrize(
    ("stamp", "run", "leaves"),
    [
        (START, 1, 0),
        (START + 7, 1, 7),
        (START - 10**9, 1, -(10**9)),
        (f"{START + 1} {START + 2}", 1, "1 2"),
        ("", 1, ""),
        (0, 1, None),
        (1_800_000_000 * 10**9, 1, None),
        (f"{START + 1} 0", 1, None),
        ("soon", 1, None),
        (5, 2, 0),
        (0, 2, None),
        (START, 3, None),
        (START, None, None),
    ],
)
def test_a_stamp_counts_from_the_start_of_its_run(stamp: Any, run: int | None, leaves: Any) -> None:
    assert STARTS.since(stamp, run) == leaves


@pytest.mark.parametrize(
    ("name", "value", "leaves"),
    [
        ("details_turn_ns", START + 3, 3),
        ("details_turn", START + 3, 3),
        ("details_turn", float(START + 4096), 4096.0),
        ("details_gap_ns", 2_000_000, 2_000_000),
        ("details_count", 12, 12),
        ("details_ready", True, True),
        ("details_at", 1_800_000_000.5, 1_800_000_000.5 - DAY),
        ("details_at_ms", 1_800_000_000_000, 1_800_000_000_000 - DAY * 1000),
        ("data_seed", 1_800_000_000, 1_800_000_000),
        ("data_day", "2026-03-02", "2026-03-01"),
        ("data_day", "2026-03-02T10:00:01.5+00:00", "2026-03-01T10:00:01.5+00:00"),
        ("data_day", "2026-03-02 was fine", "2026-03-02 was fine"),
        ("data_steps", f'[{START + 1},{{"utc":"2026-03-02"}}]', '[1,{"utc":"2026-03-01"}]'),
        ("data_steps", "[no JSON", "[no JSON"),
    ],
)
def test_what_a_task_keeps_tells_no_clock_and_no_date(name: str, value: Any, leaves: Any) -> None:
    assert without_dates(name, value, START, days=-1) == leaves


@pytest.mark.parametrize(("name", "leaves"), [("details_count", 12), ("details_turn_ns", 2)])
def test_small_numbers_stay_although_the_machine_had_just_been_started(
    name: str, leaves: int
) -> None:
    assert without_dates(name, 12, start=10, days=-1) == leaves


def test_times_within_each_run_of_a_resumed_session_stay(tmp_path: Path) -> None:
    resumed(tmp_path / "data")
    export_csv(tmp_path / "data", tmp_path / "plain")
    export_csv(tmp_path / "data", tmp_path / "out", recode=tmp_path / "map.csv")
    starts = {row["run"]: row["clock_ns"] for row in read_csv(tmp_path / "plain", "runs")}
    assert [row["clock_ns"] for row in read_csv(tmp_path / "out", "runs")] == [0, 0]
    for table, stamp, run in (
        ("trials", "onset_ns", "run"),
        ("attempts", "started_ns", "started_run"),
        ("attempts", "ended_ns", "run"),
        ("actions", "decided_ns", "run"),
        ("outputs", "ended_ns", "run"),
        ("notes", "at_ns", "run"),
    ):
        plain = [
            row[stamp] and row[stamp] - starts[row[run]]
            for row in read_csv(tmp_path / "plain", table)
        ]
        assert [row[stamp] for row in read_csv(tmp_path / "out", table)] == plain, table


def test_rows_of_a_resumed_session_name_the_run_whose_clock_stamped_them(tmp_path: Path) -> None:
    resumed(tmp_path / "data")
    export_csv(tmp_path / "data", tmp_path / "out", with_notes=True)
    notes = [(row["text"], row["run"]) for row in read_csv(tmp_path / "out", "notes")]
    assert notes == [("in run 1", 1), ("in run 2", 2)]
    begun = {row["run"]: row["clock_ns"] for row in read_csv(tmp_path / "out", "runs")}
    assert begun[2] < begun[1], "the second run's clock began anew"
    actions = read_csv(tmp_path / "out", "actions")
    assert {row["run"] for row in actions} == {1, 2}
    for row in actions:
        assert row["run"] == (1 if row["decided_ns"] >= begun[1] else 2)
    first, second = read_csv(tmp_path / "out", "attempts")
    assert [(row["started_run"], row["run"]) for row in (first, second)] == [(1, 1), (1, 2)]
    assert second["started_ns"] >= begun[1] > second["ended_ns"] >= begun[2]

"""Sessions leave as MATLAB files; Octave reads in them what the CSV files of the same sessions
say.
"""

from datetime import datetime
from pathlib import Path
from typing import Any

import pytest
import scipy.io
from scipy.io.matlab import MatWriteError

from sar_tui.export.formats.mat import short_names
from tests.export import mat_files
from tests.export.exported import export_as, read_csv
from tests.export.resumed import resumed
from tests.export.varied import NOTE, store_trials, varied
from tests.needs_statistics import needs_octave
from tests.program import Call
from tests.store.by_hand import sql


def as_columns(folder: Path, table: str) -> dict[str, list[Any]]:
    """Return the columns of a CSV file."""
    rows = read_csv(folder, table)
    return {name: [row[name] for row in rows] for name in (rows[0] if rows else ())}


def sorted_rows(columns: dict[str, list[Any]], names: Any) -> list[Any]:
    """Return the rows of some columns; all numbers are floats."""
    rows = zip(*(columns[name] for name in names), strict=True)
    plain = [tuple(float(v) if type(v) in (int, bool) else v for v in row) for row in rows]
    return sorted(plain, key=repr)


@pytest.mark.slow
@needs_octave
def test_octave_reads_every_table_as_the_csv_files_have_it(tmp_path: Path) -> None:
    data = tmp_path / "data"
    varied(data)
    sql(data, "UPDATE sessions SET task='gone' WHERE task='pairs'")
    sql(data, "UPDATE imu_chunks SET data=zeroblob(60) WHERE stream=1 AND seq=2")
    written, exported = (
        export_as(form, data, tmp_path / form, with_notes=True, with_events=True)
        for form in ("csv", "mat")
    )
    assert (exported.sessions, exported.problems) == (written.sessions, written.problems)
    assert any("is damaged" in problem for problem in exported.problems)
    found = mat_files.columns(tmp_path / "mat")
    samples = found.pop("imu")
    for table, columns in found.items():
        expected = as_columns(tmp_path / "csv", table)
        assert sorted_rows(columns, expected) == sorted_rows(expected, expected)
        if expected:
            assert {name for name in columns if not name.endswith("_s")} <= set(expected)
        else:
            assert not any(columns.values())
    assert NOTE in found["notes"]["text"]
    imu = as_columns(tmp_path / "csv", "imu")
    assert (samples["at_ns"], samples["host_ns"]) == (imu["at_ns"], imu["host_ns"])
    measured = [name for name in imu if name not in ("session", "stream", "at_ns", "host_ns")]
    for number, name in enumerate(measured, 1):
        assert samples["data"][number :: 1 + len(measured)] == imu[name]


@needs_octave
def test_seconds_go_on_in_a_session_resumed_after_its_computer_went_down(tmp_path: Path) -> None:
    resumed(tmp_path / "data")
    export_as("mat", tmp_path / "data", tmp_path / "out")
    rows = mat_files.rows(tmp_path / "out", "trials")
    first, second = ([row for row in rows if row["run"] == run] for run in (1, 2))
    begun, again = mat_files.rows(tmp_path / "out", "runs")
    began, went_on = (datetime.fromisoformat(run["clock_utc"]) for run in (begun, again))
    assert (begun["clock_s"], again["clock_s"]) == (0, (went_on - began).total_seconds())
    assert second[0]["onset_ns"] < first[0]["onset_ns"], "the clock began anew"
    assert first[0]["onset_s"] == (first[0]["onset_ns"] - begun["clock_ns"]) / 1e9
    (_, cut) = mat_files.rows(tmp_path / "out", "attempts")
    assert 0 <= cut["started_s"] == (cut["started_ns"] - begun["clock_ns"]) / 1e9 < 60
    since = (second[0]["onset_ns"] - again["clock_ns"]) / 1e9
    assert second[0]["onset_s"] == pytest.approx(again["clock_s"] + since, abs=1e-8)


def test_names_that_are_too_long_for_matlab_are_shortened_in_the_same_way_always() -> None:
    long = ["details_" + "x" * 30, "details_" + "x" * 29 + "y"]
    short = short_names(["onset_ns", *long])
    assert short["onset_ns"] == "onset_ns"
    assert len(set(short.values())) == 3
    assert max(map(len, short.values())) == 31
    assert short_names(long[1:]) == {long[1]: short[long[1]]}


def test_the_codebook_describes_every_field(simulated: str, tmp_path: Path) -> None:
    path = "$.a_detail_with_a_name_too_long_for_matlab_ms"
    sql(tmp_path / "data", f"UPDATE trials SET details=json_set(details, '{path}', 1.5)")
    out = tmp_path / "out"
    export_as("mat", tmp_path / "data", out)
    lines = mat_files.codebook(out)
    described = {(line["table"], line["name"]) for line in lines}
    assert {(table, name) for _, table, name, _ in mat_files.with_scipy(out)} <= described
    (long,) = (line for line in lines if "too_long" in line["full_name"])
    assert len(long["name"]) == 31
    assert (long["unit"], long["type"], long["missing"]) == ("ms", "double", "NaN")
    file = scipy.io.loadmat(out / f"session_{simulated}.mat", simplify_cells=True)
    units = file["session"]["units"]["trials"]
    assert (units[long["name"]], units["onset_s"]) == ("ms", "s")


def test_a_session_too_large_for_a_file_is_named_and_the_rest_leaves(
    tmp_path: Path, simulated: str, call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    store_trials(tmp_path / "data", [])
    save = scipy.io.savemat

    def full(path: Path, values: Any) -> None:
        save(path, values)
        if simulated in path.name:
            raise MatWriteError("Matrix too large to save with Matlab 5 format")

    monkeypatch.setattr(scipy.io, "savemat", full)
    called = call("export --all --mixed --format mat --to", tmp_path / "out")
    assert called.code == 1
    assert f"Session {simulated} is left out" in called.err
    assert [path.name for path in (tmp_path / "out").glob("session_*")] == ["session_s1.mat"]

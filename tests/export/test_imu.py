"""Samples of motion sensors leave as they were measured; a damaged block is named, and the rest
leaves.
"""

import csv
import io
from contextlib import closing
from pathlib import Path

import frictionless
import numpy as np
import pytest

from sar_tui.export.formats.csv import numeric_lines
from sar_tui.store import imu
from sar_tui.store.database import connect
from tests.export.exported import export_csv, read_csv
from tests.program import Call


@pytest.fixture
def session(call: Call) -> str:
    called = call("simulate", "reaching", "--user", "poor", "--attempts", 1, "--seed", 3, "--json")
    return str(called.json["session"])


def test_samples_equal_the_database(session: str, tmp_path: Path) -> None:
    export_csv(tmp_path / "data", tmp_path / "out")
    rows = read_csv(tmp_path / "out", "imu")
    with closing(connect(tmp_path / "data")) as database:
        samples = imu.samples(database, session)
    assert [row["at_ns"] for row in rows] == samples["at"].tolist()
    assert [row["device_ms"] for row in rows] == samples["device_ms"].tolist()
    for name in ("acceleration", "rate"):
        written = np.array([[row[f"{name}_{axis}"] for axis in "xyz"] for row in rows], np.float32)
        assert np.array_equal(written, samples[name])
    assert {row["field_x"] for row in rows} == {None}, "not measured"


def test_numbers_of_samples_are_read_back_as_the_same_doubles(tmp_path: Path) -> None:
    numbers = [
        0.1,
        -0.0,
        5e-324,
        1.7976931348623157e308,
        1e16,
        7.5e-05,
        123456789.0,
        2**53 + 1,
        -(2**63),
    ]
    rows = [("s-1", 1, number, None) for number in numbers]
    text = "".join(numeric_lines(iter(rows), "s-1"))
    read = list(csv.reader(io.StringIO(text, newline="")))
    assert [
        (row[0], int(row[1]), type(number)(row[2]), row[3])
        for row, number in zip(read, numbers, strict=True)
    ] == [(*row[:3], "") for row in rows]
    assert text.count("\r\n") == text.count("\n") == len(rows)


def test_a_damaged_block_is_named_and_the_rest_leaves(
    call: Call, session: str, tmp_path: Path
) -> None:
    with closing(connect(tmp_path / "data")) as database:
        (before,) = database.execute("SELECT sum(n) FROM imu_chunks").fetchone()
        database.execute("UPDATE imu_chunks SET data=zeroblob(60) WHERE stream=1 AND seq=2")
        (lost,) = database.execute("SELECT n FROM imu_chunks WHERE stream=1 AND seq=2").fetchone()
    called = call("export", session, "--simulated", "--to", tmp_path / "out")
    said = (
        f"Block 2 of sensor stream 1 of session {session} is damaged: its {lost} samples are "
        "left out."
    )
    assert (called.code, called.err.split("\n")[0]) == (1, f"! {said}")
    assert len(read_csv(tmp_path / "out", "imu")) == before - lost
    assert said in (tmp_path / "out" / "sar-tui-export.json").read_text()
    assert frictionless.validate(str(tmp_path / "out" / "datapackage.json")).valid


def test_lost_samples_are_faults_of_the_sensor(session: str, tmp_path: Path) -> None:
    export_csv(tmp_path / "data", tmp_path / "out")
    faults = read_csv(tmp_path / "out", "sensor_faults")
    with closing(connect(tmp_path / "data")) as database:
        (gaps,) = database.execute(
            "SELECT count(*) FROM events WHERE topic='input/sensor' AND json_extract(message, "
            "'$.state')='gap'"
        ).fetchone()
    assert gaps == sum(row["state"] == "gap" for row in faults) > 0
    assert all(
        row["samples"] >= 1 and row["duration_ms"] > 0 for row in faults if row["state"] == "gap"
    )

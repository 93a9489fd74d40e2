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
from tests.export.exported import csv_of, read_csv
from tests.played import simulated
from tests.program import Call
from tests.store.by_hand import sql, value


@pytest.fixture
def session(tmp_path: Path) -> str:
    return simulated(tmp_path / "data", "reaching", user="poor", attempts=1)


def test_samples_equal_the_database(session: str, tmp_path: Path) -> None:
    rows = csv_of(tmp_path / "data", "imu")
    with closing(connect(tmp_path / "data")) as database:
        samples = imu.samples(database, session)
    assert [row["at_ns"] for row in rows] == samples["at"].tolist()
    assert [row["device_ms"] for row in rows] == samples["device_ms"].tolist()
    for name in ("acceleration", "rate"):
        written = np.array([[row[f"{name}_{axis}"] for axis in "xyz"] for row in rows], np.float32)
        assert np.array_equal(written, samples[name])
    assert {row["field_x"] for row in rows} == {None}, "not measured"


def test_numbers_of_samples_are_read_back_as_the_same_doubles() -> None:
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
    text = "".join(numeric_lines(iter([("s-1", 1, number, None) for number in numbers]), "s-1"))
    read = csv.reader(io.StringIO(text, newline=""))
    for (session, stream, written, empty), number in zip(read, numbers, strict=True):
        assert (session, stream, type(number)(written), empty) == ("s-1", "1", number, "")
    assert text.count("\r\n") == text.count("\n") == len(numbers)


@pytest.mark.slow
def test_a_damaged_block_is_named_others_leave(call: Call, session: str, tmp_path: Path) -> None:
    data, out = tmp_path / "data", tmp_path / "out"
    before = value(data, "SELECT sum(n) FROM imu_chunks")
    sql(data, "UPDATE imu_chunks SET data=zeroblob(60) WHERE stream=1 AND seq=2")
    lost = value(data, "SELECT n FROM imu_chunks WHERE stream=1 AND seq=2")
    called = call("export --all --simulated --to", out)
    said = f"Block 2 of sensor stream 1 of session {session} is damaged: its {lost} samples are left out."
    assert (called.code, called.err.split("\n")[0]) == (1, f"! {said}")
    assert len(read_csv(out, "imu")) == before - lost
    assert said in (out / "sar-tui-export.json").read_text()
    assert frictionless.validate(str(out / "datapackage.json")).valid


def test_lost_samples_are_faults_of_the_sensor(session: str, tmp_path: Path) -> None:
    faults = csv_of(tmp_path / "data", "sensor_faults")
    query = "SELECT count(*) FROM events WHERE topic='input/sensor' AND json_extract(message, '$.state')='gap'"
    gaps = [row for row in faults if row["state"] == "gap"]
    assert len(gaps) == value(tmp_path / "data", query) > 0
    assert all(row["samples"] >= 1 and row["duration_ms"] > 0 for row in gaps)

"""Recordings in files: samples in SI units, or a clear error."""

import io
import math
import tempfile
import tracemalloc
import zipfile
from collections.abc import Callable, Iterator
from csv import field_size_limit
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from sar_tui.inputs import recording_file
from sar_tui.inputs.imu import SourceError
from sar_tui.inputs.recording_file import VECTORS, Units, read_blocks, read_recording
from sar_tui.motion.samples import SAMPLE, Samples, recording

HEADER = "t,ax,ay,az,wx,wy,wz"
ROWS = [f"{0.01 * index:.2f},1,2,3,{index},0.5,-90" for index in range(40)]


def some_samples(count: int = 50) -> Samples:
    streams = np.random.default_rng(7)
    samples = np.zeros(count, dtype=SAMPLE)
    samples["at"] = samples["host"] = 123_456_789_012 + np.arange(count) * 4_000_000
    samples["device_ms"] = samples["at"] / 1e6
    for field in ("acceleration", "rate", "field"):
        samples[field] = streams.normal(0, 3, (count, 3))
    return samples


def write_recording(path: Path, samples: Samples) -> None:
    """Write samples to a CSV or NPZ file, without quantities that are all NaN."""
    columns: dict[str, Any] = {"t": samples["at"] / 1e9}
    for field, names in VECTORS.items():
        if not np.isnan(samples[field]).all():
            columns |= dict(zip(names, samples[field].T, strict=True))
    if path.suffix.lower() == ".npz":
        with path.open("wb") as file:
            np.savez_compressed(file, **columns)
    else:
        rows = np.column_stack(list(columns.values()))
        formats = ["%.9f", *["%.9g"] * (len(columns) - 1)]
        np.savetxt(path, rows, formats, ",", header=",".join(columns), comments="")


@pytest.fixture(autouse=True)
def usual_field_limit() -> Iterator[None]:
    """Set the longest field of a CSV file to its default: other libraries of the tests raise it for
    the process.
    """
    before = field_size_limit(131_072)
    yield
    field_size_limit(before)


@pytest.fixture
def csv(tmp_path: Path) -> Callable[..., Path]:
    """Write lines to a file."""

    def write(*lines: str, end: str = "\n", encoding: str = "utf-8") -> Path:
        path = tmp_path / "walk.csv"
        path.write_bytes((end.join(lines) + end).encode(encoding))
        return path

    return write


@pytest.fixture
def npz(tmp_path: Path) -> Callable[..., Path]:
    """Write arrays to a file: valid ones, except those given; None leaves one out."""

    def write(**changed: Any) -> Path:
        good: dict[str, Any] = {name: np.linspace(0, 1, 40) for name in ("t", "wx", "wy", "wz")}
        path = tmp_path / "walk.npz"
        np.savez(
            path, **{name: array for name, array in (good | changed).items() if array is not None}
        )
        return path

    return write


def fault(path: Path, units: Units = recording_file.SI) -> str:
    """Return the error message for a file that cannot be read."""
    with pytest.raises(SourceError) as caught:
        read_recording(path, units)
    said = str(caught.value)
    assert str(path) in said
    assert said.endswith(".")
    assert "\n" not in said
    return said.replace(str(path), "FILE")


def test_a_table_is_read_and_converted_from_degrees_and_g(csv: Callable[..., Path]) -> None:
    samples = read_recording(csv(HEADER, *ROWS))
    assert samples["at"].tolist() == [10_000_000 * index for index in range(40)]
    assert samples["host"].tolist() == samples["at"].tolist()
    assert np.allclose(samples["device_ms"], 10.0 * np.arange(40))
    assert samples["rate"][5].tolist() == [5.0, 0.5, -90.0]
    assert samples["acceleration"][5].tolist() == [1.0, 2.0, 3.0]
    assert np.isnan(samples["field"]).all()
    assert recording(samples).rate_hz == pytest.approx(100)
    converted = read_recording(csv(HEADER, *ROWS), Units(rate="deg/s", acceleration="g"))
    assert converted["rate"][0, 2] == pytest.approx(-math.pi / 2)
    assert converted["acceleration"][0, 1] == pytest.approx(2 * 9.80665)


def test_acceleration_is_optional_and_other_columns_are_ignored(csv: Callable[..., Path]) -> None:
    samples = read_recording(
        csv("label,wz,wy,wx,t", *(f"hand,3,2,1,{0.01 * index:.2f}" for index in range(30)))
    )
    assert samples["rate"][0].tolist() == [1.0, 2.0, 3.0]
    assert np.isnan(samples["acceleration"]).all()
    assert recording(samples).acceleration is None
    samples = read_recording(csv(HEADER, *ROWS[:3], "0.03,nan,nan,nan,4,5,6", *ROWS[4:]))
    assert np.isnan(samples["acceleration"]).any(axis=1).tolist().count(True) == 1


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("header", [HEADER, HEADER.replace(",", " , ")])
def test_tables_from_spreadsheets_are_read(
    csv: Callable[..., Path], encoding: str, end: str, header: str
) -> None:
    assert len(read_recording(csv(header, *ROWS, "", " ", end=end, encoding=encoding))) == 40


@pytest.fixture
def in_small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Read files in blocks of 20 rows."""
    monkeypatch.setattr("sar_tui.inputs.recording_file.ROWS", 20)


@pytest.mark.usefixtures("in_small_blocks")
@pytest.mark.parametrize("suffix", [".csv", ".CSV", ".npz", ".NPZ"])
def test_blocks_are_the_whole_file_as_it_was_written(tmp_path: Path, suffix: str) -> None:
    path, samples = tmp_path / f"walk{suffix}", some_samples(50)
    write_recording(path, samples)
    blocks = list(read_blocks(path))
    assert [len(block) for block in blocks] == [20, 20, 10]
    again = read_recording(path)
    assert np.concatenate(blocks).tobytes() == again.tobytes()
    for field in ("at", "acceleration", "rate", "field"):
        assert again[field].tolist() == samples[field].tolist()


@pytest.mark.usefixtures("in_small_blocks")
def test_quoted_blank_and_padded_lines_are_read_as_others_are(csv: Callable[..., Path]) -> None:
    plain = read_recording(csv(HEADER, *ROWS))
    unusual = list(ROWS)
    unusual[20] = '"0.20",1,2,3,"20",0.5,-90'
    unusual[25] = " 0.25 , 1,2,3,2_5,0.5,-90"
    unusual.insert(30, "")
    assert read_recording(csv(HEADER, *unusual)).tobytes() == plain.tobytes()
    unusual[38] = "0.37,1,2"
    with pytest.raises(SourceError, match="line 40: 3 values for 7 columns"):
        read_recording(csv(HEADER, *unusual))


@pytest.mark.usefixtures("in_small_blocks")
def test_a_time_that_goes_back_between_two_blocks_is_a_fault(
    csv: Callable[..., Path], npz: Callable[..., Path]
) -> None:
    said = "the time 0.19 is the same as that of the sample above"
    assert f"FILE, line 22: {said}" in fault(csv(HEADER, *ROWS[:20], ROWS[19], *ROWS[21:]))
    times = np.arange(40) / 100
    times[20] = times[19]
    assert f"FILE, sample 21: {said}" in fault(npz(t=times))


@pytest.mark.usefixtures("in_small_blocks")
@pytest.mark.parametrize("suffix", [".csv", ".npz"])
def test_a_file_read_in_blocks_takes_no_more_memory_if_it_is_longer(
    tmp_path: Path, suffix: str
) -> None:
    peaks = []
    for count in (2000, 8000):
        path = tmp_path / f"{count}{suffix}"
        write_recording(path, some_samples(count))
        tracemalloc.start()
        try:
            assert sum(map(len, read_blocks(path))) == count
            peaks.append(tracemalloc.get_traced_memory()[1])
        finally:
            tracemalloc.stop()
    assert peaks[1] < 1.2 * peaks[0]


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ([], "FILE is empty."),
        (["\x1c"], "FILE is empty."),
        (["t,ax,ay,az,wx,wz", *ROWS], "FILE: the columns wy are missing."),
        (["t,ax,wx,wy,wz", *ROWS], "FILE: the columns ay, az are missing."),
        (["t,wx,wy,wz,mz", *ROWS], "FILE: the columns mx, my are missing."),
        (["t,t,wx,wx,wy,wz", *ROWS], "FILE: there are two columns t, wx; keep one of each."),
        ([HEADER.replace(",", ";"), *ROWS], "Separate columns by commas, not by semicolons"),
        (ROWS, "FILE: the columns t, wx, wy, wz are missing."),
        ([HEADER, "", "0,03,1,2,3,4,5,6", *ROWS], "FILE, line 3: 8 values for 7 columns; "),
        ([HEADER], "FILE holds 0 samples; at least 20 are needed."),
        ([HEADER, *ROWS[:19]], "FILE holds 19 samples; at least 20 are needed."),
        ([HEADER, *(f"{n},1,2,3,4,5,6" for n in range(40))], "FILE holds 1 samples a second"),
        ([HEADER, '0.00,"1' + "1" * 140_000], "this is not CSV: field larger than field limit"),
    ],
)
def test_a_file_that_is_no_table_of_samples_is_refused_with_the_reason(
    csv: Callable[..., Path], lines: list[str], said: str
) -> None:
    assert said in fault(csv(*lines))


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("0.03,1,2,3,4,5", "6 values for 7 columns; "),
        ("0.03,1,2,3,x,5,6", '"x" in the column wx is not a number.'),
        ("0.03,1,2,3,4,,6", '"" in the column wy is not a number.'),
        ("0.03,1,2,3,nan,5,6", "nan in the column wx is no measurement"),
        ("0.03,1,2,3,4,-inf,6", "-inf in the column wy is no measurement"),
        ("0.03,1,2,3,4,5,1e40", "1e+40 in the column wz is no measurement"),
        ("0.03,inf,2,3,4,5,6", "inf in the column ax is no measurement"),
        ("0.02,1,2,3,4,5,6", "the time 0.02 is the same as that of the sample above"),
        ("0.01,1,2,3,4,5,6", "the time 0.01 is before that of the sample above"),
        ("nan,1,2,3,4,5,6", "the time nan cannot be; t is in seconds."),
        ("1.7e12,1,2,3,4,5,6", "the time 1.7e+12 cannot be; t is in seconds."),
    ],
)
def test_a_fault_is_reported_with_its_line(csv: Callable[..., Path], row: str, said: str) -> None:
    assert f"FILE, line 5: {said}" in fault(csv(HEADER, *ROWS[:3], row, *ROWS[4:]))


def test_text_that_is_not_utf_8_is_reported_with_its_line(csv: Callable[..., Path]) -> None:
    assert "FILE, line 2: this is not UTF-8 text" in fault(
        csv(HEADER, "0,1,2,3,4,5,6 é", encoding="latin-1")
    )
    assert "this is not UTF-8 text" in fault(csv(HEADER, *ROWS, encoding="utf-16"))


def test_a_path_that_is_not_a_file_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert fault(tmp_path / "none.csv") == "There is no file FILE."
    assert fault(tmp_path) == "FILE is not a file: name a recording, FILE.csv or FILE.npz."
    secret = tmp_path / "secret.csv"
    secret.write_text("t")

    def refuse(_: Path, *args: Any, **options: Any) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)
    assert fault(secret) == "FILE cannot be read: Permission denied."


def test_a_file_too_large_for_memory_is_refused(
    csv: Callable[..., Path], npz: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    table = csv(HEADER, *ROWS)
    bomb = npz(t=np.zeros(100_000))
    with zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("t.npy", bytes(100_000))
    monkeypatch.setattr(recording_file, "LARGEST", 800)
    assert bomb.stat().st_size < 800 < table.stat().st_size
    assert "larger than 1 GiB" in fault(table)
    assert "unpacks to more than 1 GiB" in fault(bomb)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"wx": None}, "FILE: the columns wx are missing."),
        ({"ax": np.zeros(40)}, "FILE: the columns ay, az are missing."),
        ({"wx": np.zeros(39)}, "FILE: the arrays wx are not as long as t."),
        ({"wx": np.zeros((40, 2))}, "FILE: the array wx must be one row of numbers."),
        ({"wx": np.array(["1"] * 40)}, "FILE: the array wx must be one row of numbers."),
        ({"wx": np.zeros(40, dtype=complex)}, "FILE: the array wx must be one row of numbers."),
        (
            {"wx": np.array([print] * 40, dtype=object)},
            "FILE: the array wx cannot be read: Object arrays",
        ),
        ({"wx": np.full(40, np.nan)}, "FILE, sample 1: nan in the column wx is no measurement"),
        ({"t": np.zeros(40)}, "FILE, sample 2: the time 0 is the same as"),
    ],
)
def test_a_fault_of_the_arrays_is_reported(
    npz: Callable[..., Path], changed: dict[str, Any], said: str
) -> None:
    assert said in fault(npz(**changed))


def test_a_damaged_archive_or_one_that_claims_an_impossible_size_is_reported(
    npz: Callable[..., Path],
) -> None:
    path = npz()
    whole = path.read_bytes()
    for keep in (10, 300, -30):
        path.write_bytes(whole[:keep])
        assert "FILE is not an NPZ file, or it is damaged" in fault(path)
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        header, {"descr": "<f8", "fortran_order": False, "shape": (1 << 50,)}
    )
    with zipfile.ZipFile(path, "w") as archive:
        for name in ("t", "wx", "wy", "wz"):
            archive.writestr(f"{name}.npy", header.getvalue())
    assert "FILE is not an NPZ file, or it is damaged" in fault(path)


@given(st.binary(max_size=300))
def test_arbitrary_data_is_not_read_as_a_recording(rubbish: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        for name in ("rubbish.csv", "rubbish.npz"):
            path = Path(folder) / name
            path.write_bytes(rubbish)
            fault(path)


@given(
    arrays.arrays("<f4", (20, 3), elements=st.floats(-1e6, 1e6, width=32)),
    st.integers(-(10**15), 10**15),
    st.integers(1, 50 * 10**6),
)
def test_a_table_keeps_every_bit_of_a_measurement(rate: Any, start: int, step: int) -> None:
    samples = np.zeros(20, dtype=SAMPLE)
    samples["at"] = start + np.arange(20) * step
    samples["rate"] = rate
    samples["acceleration"] = samples["field"] = np.nan
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "walk.csv"
        write_recording(path, samples)
        again = read_recording(path)
    assert again["at"].tolist() == samples["at"].tolist()
    assert again["rate"].tolist() == samples["rate"].tolist()

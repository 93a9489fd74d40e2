"""``sar-tui detect``: reaches and repetitions in a file, for people and programs; errors in one
sentence.
"""

import csv
import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

import sar_tui
from sar_tui.cli.detect import Acceleration, Hand, Rate, explain_flags
from sar_tui.inputs.recording_file import Units
from sar_tui.motion.analysis import AnalysisParameters
from sar_tui.motion.detection import DETECTORS
from sar_tui.motion.detector_names import COLUMN_NAMES
from sar_tui.motion.reach import Reach
from sar_tui.motion.synthesis import TABLE_4_1
from tests.motion.test_repetitions import WATCH_HZ, watch_sets
from tests.program import Call

SAMPLE = Path(sar_tui.__file__).parent.parent / "data" / "table-4.1.csv"
Row = dict[str, float]
Write = Callable[..., Path]


@pytest.fixture(scope="module")
def recorded() -> list[Row]:
    """Return the rows of the included recording."""
    with SAMPLE.open(newline="") as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


def reaches(call: Call, path: Path, *options: str) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = call("detect", path, *options, "--json").json["reaches"]
    return found


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Write rows to a file and return its path."""

    def write(rows: list[Row], name: str = "some.csv") -> Path:
        path = tmp_path / name
        with path.open("w", newline="") as file:
            out = csv.DictWriter(file, list(rows[0]))
            out.writeheader()
            out.writerows(rows)
        return path

    return write


def test_the_recording_that_ships_holds_the_eight_reaches_of_table_4_1(call: Call) -> None:
    printed = call("detect", SAMPLE, "--json").json
    assert set(printed) == {"detector", "rate_hz", "reaches"}
    assert (printed["detector"], printed["rate_hz"]) == ("orientation", 125.0)
    for reach, line in zip(printed["reaches"], TABLE_4_1, strict=True):
        assert set(reach) == {field.name for field in msgspec.structs.fields(Reach)}
        assert reach["reach_time_s"] == pytest.approx(line.reach_time_s, abs=0.06)
        assert reach["peak_extension_rad_s"] == pytest.approx(line.peak_extension_rad_s, rel=0.03)
        assert reach["peak_return_rad_s"] == pytest.approx(line.peak_return_rad_s, rel=0.03)
        assert reach["flags"] == []


def test_another_detector_finds_other_times(call: Call) -> None:
    printed = call("detect", SAMPLE, "--detector", "fixed-threshold", "--json").json
    assert printed["detector"] == "fixed-threshold"
    for reach, line in zip(printed["reaches"], TABLE_4_1, strict=True):
        assert reach["reach_time_s"] < line.reach_time_s


def test_people_read_a_table_the_flags_in_words_and_a_sentence(
    call: Call, write: Write, recorded: list[Row]
) -> None:
    called = call("detect", write([row for row in recorded if 1.7 < row["t"] < 8]))
    called.shows("SPARC", "no_rest: the hand was not still before it", "1.323 to 1.391 s, median")
    assert called.out.splitlines()[-1].startswith("2 reaches in 6.3 s at 125 samples a second")


@pytest.mark.parametrize("columns", [40, 80])
def test_every_figure_is_printed_whole_however_narrow_the_terminal(
    call: Call, write: Write, recorded: list[Row], monkeypatch: pytest.MonkeyPatch, columns: int
) -> None:
    """Times since 1970 have ten digits before the point."""
    monkeypatch.setenv("COLUMNS", str(columns))
    path = write([{**row, "t": row["t"] + 1_700_000_000} for row in recorded])
    reach = reaches(call, path)[0]
    times = [f"{reach[name]:.3f}" for name in ("onset_s", "turn_s", "end_s", "reach_time_s")]
    names = ("peak_extension_rad_s", "peak_return_rad_s", "sparc_out", "sparc_back")
    rest = [f"{reach[name]:.2f}" for name in names]
    row = ["1", *times, f"{reach['excursion_deg']:.0f}", *rest, "–"]
    assert row in [line.split() for line in call("detect", path).out.splitlines()]


def test_every_flag_is_described_even_an_unknown_one() -> None:
    assert list(explain_flags(["gap", "new", "gap"])) == ["gap: samples are missing in it", "new"]


def test_a_recording_without_a_reach_is_no_error(
    call: Call, write: Write, recorded: list[Row]
) -> None:
    path = write(recorded[:150])
    assert reaches(call, path) == []
    call("detect", path).shows("No reach in 1.2 s at 125 samples a second")


@pytest.mark.parametrize("begin", [5, -20, 1_700_000_000])
def test_times_are_relative_to_the_file(
    call: Call, write: Write, recorded: list[Row], begin: float
) -> None:
    late = write([row | {"t": row["t"] + begin} for row in recorded])
    for now, then in zip(reaches(call, late), reaches(call, SAMPLE), strict=True):
        for name in ("onset_s", "turn_s", "end_s"):
            assert now[name] == pytest.approx(then[name] + begin, rel=0, abs=1e-4)


def test_a_recording_that_begins_without_a_still_second_is_analysed_and_flagged(
    call: Call, write: Write, recorded: list[Row]
) -> None:
    first, *others = reaches(call, write([row for row in recorded if row["t"] > 1.7]))
    assert "no_rest" in first["flags"]
    assert [reach["flags"] for reach in others] == [[]] * 7


def test_missing_samples_are_flagged(call: Call, write: Write, recorded: list[Row]) -> None:
    first, *_ = reaches(call, write([*recorded[:300], *recorded[340:]]))
    assert first["flags"] == ["gap"]


def test_the_units_of_a_file_can_be_named(call: Call, write: Write, recorded: list[Row]) -> None:
    units = {"w": math.degrees(1.0), "a": 1 / 9.80665, "t": 1.0}
    other = [{name: value * units[name[0]] for name, value in row.items()} for row in recorded]
    named = reaches(call, write(other), "--rate", "deg/s", "--acceleration", "g")
    for now, then in zip(named, reaches(call, SAMPLE), strict=True):
        assert now["reach_time_s"] == pytest.approx(then["reach_time_s"], abs=1e-6)


def test_the_outward_direction_is_reversed_for_the_left_hand(call: Call) -> None:
    for hand in ("right", "left"):
        found = {"reversed" in reach["flags"] for reach in reaches(call, SAMPLE, "--hand", hand)}
        assert found == {hand == "left"}


def rows_at(times: Iterable[float]) -> str:
    return "t,wx,wy,wz\n" + "".join(f"{time},0,0,0\n" for time in times)


def swings(path: Path, count: int, begin: float = 0.0) -> Path:
    """Write a recording in which the hand turns by a radian and back, ``count`` times in 2 s
    each.
    """
    time = np.arange(0, 2 * count, 0.01)
    rate = np.pi / 2 * np.sin(np.pi * time)
    still = np.zeros_like(time)
    np.savez(path, t=time + begin, wx=rate, wy=still, wz=still)
    return path


def test_repetitions_are_counted(call: Call, tmp_path: Path) -> None:
    called = call("detect", swings(tmp_path / "swings.npz", 7), "--repetitions")
    called.shows("7 repetitions in 14.0 s at 100 samples a second, one every 2.00 s.\n")
    late = swings(tmp_path / "swings.npz", 7, begin=100.0)
    printed = call("detect", late, "--repetitions", "--json").json
    assert set(printed) == {"rate_hz", "repetitions", "period_s", "turns_s"}
    assert (printed["rate_hz"], printed["repetitions"]) == (100.0, 7)
    assert printed["period_s"] == pytest.approx(2.0, abs=0.05)
    assert printed["turns_s"] == pytest.approx([101.0 + 2 * number for number in range(7)], abs=0.1)


def test_a_recording_without_a_rhythm_has_no_repetitions(call: Call, tmp_path: Path) -> None:
    path = tmp_path / "still.npz"
    rest = np.random.default_rng(1).normal(0, 0.01, (3, 1000))
    np.savez(path, t=np.arange(1000) / 100, wx=rest[0], wy=rest[1], wz=rest[2])
    call("detect", path, "--repetitions").shows("No repetitions in 10.0 s at 100 samples a second")
    printed = call("detect", path, "--repetitions", "--json").json
    assert (printed["repetitions"], printed["period_s"], printed["turns_s"]) == (0, None, [])


def test_repetitions_of_a_recorded_exercise(call: Call, tmp_path: Path) -> None:
    """A set of 20 repetitions, recorded at 50 Hz by a watch: the first of seglearn's data."""
    path = tmp_path / "watch.npz"
    whole = watch_sets()[0]
    columns = zip("wx wy wz".split(), whole.rate.T, strict=True)
    np.savez(path, t=np.arange(len(whole.rate)) / WATCH_HZ, **dict(columns))
    call("detect", path, "--repetitions").shows("20 repetitions in ")


def test_npz_files_are_read_too(call: Call, tmp_path: Path, recorded: list[Row]) -> None:
    path = tmp_path / "some.npz"
    np.savez(path, **{name: np.array([row[name] for row in recorded]) for name in recorded[0]})
    assert call("detect", path, "--json").out == call("detect", SAMPLE, "--json").out


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "is empty."),
        ("t,wx,wy,wz\n", "holds 0 samples; at least 20 are needed."),
        ("t,wx,wy\n0,1,2\n", "the columns wz are missing."),
        ("t;wx;wy;wz\n0;1;2;3\n", "Separate columns by commas"),
        ("t,wx,wy,wz\n0,1,2\n", "line 2: 3 values for 4 columns"),
        ("t,wx,wy,wz\n0,1,2,three\n", '"three" in the column wz is not a number.'),
        ("t,wx,wy,wz\n0,1,2,nan\n", "nan in the column wz is no measurement"),
        (rows_at(n % 5 for n in range(30)), "it must be later."),
        (rows_at(range(30)), "1 samples a second"),
        (rows_at(n / 100 + (n > 20) * 1e8 for n in range(40)), "cut it where samples are missing."),
        (b"\xff\xfe\x00\x01", ""),
        (b"PK\x03\x04 no archive", ""),
    ],
    ids=lambda value: str(value)[:30],
)
def test_a_bad_file_exits_with_2_and_one_sentence(
    call: Call, tmp_path: Path, text: str | bytes, says: str
) -> None:
    path = tmp_path / ("bad.npz" if text[:2] == b"PK" else "bad.csv")
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    called = call("detect", path)
    called.refused(says, str(path))
    assert called.err.count("\n") == 1


def test_the_choices_are_the_available_detectors() -> None:
    assert set(COLUMN_NAMES) == set(DETECTORS)
    for name, choices in (("rate", Rate), ("acceleration", Acceleration)):
        for choice in choices:
            assert getattr(msgspec.convert({name: choice.value}, Units), name) == choice.value
    for hand in Hand:
        assert msgspec.convert({"hand": hand.value}, AnalysisParameters).hand == hand.value


def test_reaches_without_a_way_back_have_no_measures_of_it(call: Call, write: Write) -> None:
    time_s = np.arange(600) / 100
    share = np.clip((time_s - 2.0) / 1.0, 0.0, 1.0)
    turning = 30.0 * (share * (1.0 - share)) ** 2
    moved = zip(time_s, turning, strict=True)
    path = write([{"t": t, "wx": 0.0, "wy": 0.6 * w, "wz": 0.8 * w} for t, w in moved])
    assert reaches(call, path) == []
    (reach,) = reaches(call, path, "--one-way")
    assert set(reach) == {field.name for field in msgspec.structs.fields(Reach)}
    assert reach["reach_time_s"] == reach["out_s"] == pytest.approx(1.0, abs=0.08)
    assert reach["excursion_deg"] == pytest.approx(math.degrees(1.0), abs=2.0)
    of_the_way_back = ("turn_s", "back_s", "dwell_s", "peak_return_rad_s", "sparc_back")
    assert {reach[name] for name in of_the_way_back} == {None}
    call("detect", path, "--one-way").shows("One reach in")


def test_a_recording_in_radians_read_as_degrees_gets_a_hint(call: Call) -> None:
    hint = "If the file is in rad/s, leave out --rate deg/s."
    called = call("detect", SAMPLE, "--rate", "deg/s")
    assert (called.code, called.out.startswith("No reach in"), hint in called.err) == (
        0,
        True,
        True,
    )
    assert reaches(call, SAMPLE, "--rate", "deg/s") == []
    assert call("detect", SAMPLE).err == ""

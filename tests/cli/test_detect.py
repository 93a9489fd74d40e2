"""``sar-tui detect``: reaches and repetitions in a file, for people and programs; errors in one
sentence.
"""

import csv
import math
from collections.abc import Callable
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


def test_the_detector_the_hand_and_the_units_of_the_file_can_be_named(
    call: Call, write: Write, recorded: list[Row]
) -> None:
    printed = call("detect", SAMPLE, "--detector", "fixed-threshold", "--json").json
    assert printed["detector"] == "fixed-threshold"
    for reach, line in zip(printed["reaches"], TABLE_4_1, strict=True):
        assert reach["reach_time_s"] < line.reach_time_s
    for hand in ("right", "left"):
        found = {"reversed" in reach["flags"] for reach in reaches(call, SAMPLE, "--hand", hand)}
        assert found == {hand == "left"}
    units = {"w": math.degrees(1.0), "a": 1 / 9.80665, "t": 1.0}
    other = [{name: value * units[name[0]] for name, value in row.items()} for row in recorded]
    named = reaches(call, write(other), "--rate", "deg/s", "--acceleration", "g")
    for now, then in zip(named, reaches(call, SAMPLE), strict=True):
        assert now["reach_time_s"] == pytest.approx(then["reach_time_s"], abs=1e-6)


def test_people_read_a_table_the_flags_in_words_and_a_sentence(
    call: Call, write: Write, recorded: list[Row]
) -> None:
    called = call("detect", write([row for row in recorded if 1.7 < row["t"] < 8]))
    called.shows("no_rest: the hand was not still before it", "1.323 to 1.391 s, median")
    assert called.out.splitlines()[-1].startswith("2 reaches in 6.3 s at 125 samples a second")
    call("detect", write(recorded[:150])).shows("No reach in 1.2 s at 125 samples a second")
    assert list(explain_flags(["gap", "new", "gap"])) == ["gap: samples are missing in it", "new"]


@pytest.mark.parametrize("begin", [-20, 1_700_000_000])
def test_times_are_relative_to_the_file_and_printed_whole_however_narrow_the_terminal(
    call: Call, write: Write, recorded: list[Row], monkeypatch: pytest.MonkeyPatch, begin: float
) -> None:
    """Times since 1970 have ten digits before the point."""
    monkeypatch.setenv("COLUMNS", "40")
    path = write([row | {"t": row["t"] + begin} for row in recorded])
    found = reaches(call, path)
    for now, then in zip(found, reaches(call, SAMPLE), strict=True):
        for name in ("onset_s", "turn_s", "end_s"):
            assert now[name] == pytest.approx(then[name] + begin, rel=0, abs=1e-4)
    reach = found[0]
    times = [f"{reach[name]:.3f}" for name in ("onset_s", "turn_s", "end_s", "reach_time_s")]
    names = ("peak_extension_rad_s", "peak_return_rad_s", "sparc_out", "sparc_back")
    rest = [f"{reach[name]:.2f}" for name in names]
    row = ["1", *times, f"{reach['excursion_deg']:.0f}", *rest, "–"]
    assert row in [line.split() for line in call("detect", path).out.splitlines()]


def swings(path: Path, rate: Any, begin: float = 0.0) -> Path:
    """Write a recording with a rate about x, 100 samples a second."""
    still = np.zeros_like(rate)
    np.savez(path, t=np.arange(len(rate)) / 100 + begin, wx=rate, wy=still, wz=still)
    return path


def test_repetitions_are_counted(call: Call, tmp_path: Path) -> None:
    path = tmp_path / "swings.npz"
    seven = np.pi / 2 * np.sin(np.pi * np.arange(0, 14, 0.01))
    called = call("detect", swings(path, seven), "--repetitions")
    called.shows("7 repetitions in 14.0 s at 100 samples a second, one every 2.00 s.\n")
    printed = call("detect", swings(path, seven, begin=100.0), "--repetitions", "--json").json
    assert set(printed) == {"rate_hz", "repetitions", "period_s", "turns_s"}
    assert (printed["rate_hz"], printed["repetitions"]) == (100.0, 7)
    assert printed["period_s"] == pytest.approx(2.0, abs=0.05)
    assert printed["turns_s"] == pytest.approx([101.0 + 2 * number for number in range(7)], abs=0.1)
    swings(path, np.random.default_rng(1).normal(0, 0.01, 1000))
    call("detect", path, "--repetitions").shows("No repetitions in 10.0 s at 100 samples a second")
    printed = call("detect", path, "--repetitions", "--json").json
    assert (printed["repetitions"], printed["period_s"], printed["turns_s"]) == (0, None, [])


def test_a_bad_file_exits_with_2_and_one_sentence(call: Call, tmp_path: Path) -> None:
    """The faults of a file have their table in tests/inputs/test_recording_file.py."""
    lost = "".join(f"{n / 100 + (n > 20) * 1e8},0,0,0\n" for n in range(40))
    for text, said in (
        ("t,wx,wy,wz\n0,1,2,three\n", '"three" in the column wz is not a number.'),
        (f"t,wx,wy,wz\n{lost}", "cut it where samples are missing."),
    ):
        path = tmp_path / "bad.csv"
        path.write_text(text)
        called = call("detect", path)
        called.refused(said, str(path))
        assert called.err.count("\n") == 1


def test_a_recording_in_radians_read_as_degrees_gets_a_hint(call: Call) -> None:
    called = call("detect", SAMPLE, "--rate", "deg/s")
    assert (called.code, called.out.startswith("No reach in")) == (0, True)
    assert "leave out --rate deg/s." in called.err
    assert call("detect", SAMPLE).err == ""


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


def test_the_first_reaches_of_a_person_leave_out_movements_that_are_much_smaller(
    call: Call, recorded: list[Row], write: Write
) -> None:
    found = reaches(call, SAMPLE)
    assert reaches(call, SAMPLE, "--calibrate", "3") == found
    says = "By this person's reaches: 8° or more, 4.2 s or less."
    assert says in call("detect", SAMPLE, "--calibrate", "3").out
    one = next(reach for reach in found if reach["excursion_deg"] > 60)
    own = [row for row in recorded if one["onset_s"] - 1.0 < row["t"] < one["end_s"] + 1.0]
    lasts_s = own[-1]["t"] - own[0]["t"] + 0.008
    rows = [
        {name: share * value if name[0] == "w" else value for name, value in row.items()}
        | {"t": row["t"] + number * lasts_s}
        for number, share in enumerate((1.0, 1.0, 0.3))
        for row in own
    ]
    both = write(rows)
    assert len(reaches(call, both)) == 3
    assert len(reaches(call, both, "--calibrate", "2")) == 2
    call("detect", both, "--calibrate", "3", "--one-way").refused("--calibrate goes neither with")
    still = write([{"t": row["t"], "wx": 0.0, "wy": 0.0, "wz": 0.0} for row in recorded])
    call("detect", still, "--calibrate", "3").refused("no reach to calibrate with")

"""``sar-tui detect --labels`` and ``--calibrate-by``: corrected reaches are measured, and limits."""

import os
from pathlib import Path
from typing import Any

import msgspec
import pytest

import sar_tui
from sar_tui.app.correction.app import CorrectionApp
from sar_tui.cli.common import Home
from sar_tui.cli.correct import ByHand
from sar_tui.cli.errors import Refused
from sar_tui.inputs.imu import SourceError
from sar_tui.inputs.label_file import beside, read_labels
from sar_tui.inputs.recording_file import read_blocks
from sar_tui.motion.detection import detect_long
from sar_tui.motion.labels import Correction, Label, labelled
from tests.program import Call

SAMPLE = Path(sar_tui.__file__).parent.parent / "data" / "table-4.1.csv"


def reaches(call: Call, *options: object) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = call("detect", *options, "--json").json["reaches"]
    return found


@pytest.fixture
def labels(tmp_path: Path) -> Path:
    """Labels of the included recording: one reach accepted, one dropped, one moved, one added in
    the place of another one.
    """
    path = tmp_path / "labels.json"
    by_hand = ByHand(SAMPLE, path, "orientation", "right", may_be_new=True)
    found = detect_long(by_hand.keep(read_blocks(SAMPLE)))
    edited = Correction(labelled(found.reaches), found.begins_s, found.ends_s)
    edited.accept(0)
    edited.drop(1)
    edited.move(2, "end", 0.25)
    middle_s = (edited.labels[3].start_s + edited.labels[3].end_s) / 2
    edited.drop(3)
    edited.insert(middle_s)
    by_hand.save(edited.labels)
    return path


def test_the_corrected_reaches_are_measured(call: Call, labels: Path) -> None:
    before, after = reaches(call, SAMPLE), reaches(call, SAMPLE, "--labels", labels)
    assert len(after) == len(before) - 1
    assert after[0] == before[0], "it was not changed"
    assert after[1]["onset_s"] == before[2]["onset_s"]
    assert after[1]["end_s"] == pytest.approx(before[2]["end_s"] + 0.25)
    assert after[1]["reach_time_s"] == pytest.approx(before[2]["reach_time_s"] + 0.25)
    assert after[1]["peak_extension_rad_s"] == pytest.approx(before[2]["peak_extension_rad_s"])
    added = after[2]
    assert (added["confidence"], before[3]["confidence"] is None) == (None, False)
    assert added["turn_s"] == pytest.approx(before[3]["turn_s"], abs=0.1)
    assert added["excursion_deg"] == pytest.approx(before[3]["excursion_deg"], abs=2.0)
    shown = call("detect", SAMPLE, "--labels", labels)
    shown.shows("by the orientation detector, corrected by hand")


def test_corrected_reaches_are_the_limits_of_the_person(call: Call, labels: Path) -> None:
    assert len(reaches(call, SAMPLE, "--calibrate-by", labels)) == 8
    content = read_labels(labels)
    large = tuple(msgspec.structs.replace(label, excursion_deg=170.0) for label in content.reaches)
    labels.write_bytes(msgspec.json.encode(msgspec.structs.replace(content, reaches=large)))
    assert len(reaches(call, SAMPLE, "--calibrate-by", labels)) < 8
    assert all(label.excursion_deg for label in content.reaches if label.counts)


def test_labels_nobody_has_looked_at_are_no_limits(call: Call, labels: Path) -> None:
    content = read_labels(labels)
    found = tuple(label for label in content.reaches if label.state == "found")
    labels.write_bytes(msgspec.json.encode(msgspec.structs.replace(content, reaches=found)))
    call("detect", SAMPLE, "--calibrate-by", labels).refused("No reach in", "was accepted, moved")


@pytest.mark.parametrize("option", ["--labels", "--calibrate-by"])
@pytest.mark.parametrize("text", ["", "{", "\ufeff[]", '{"reaches": 3}', "\x00" * 9, "[" * 9999])
def test_a_broken_file_of_labels_is_one_sentence(
    call: Call, tmp_path: Path, option: str, text: str
) -> None:
    path = tmp_path / "labels.json"
    path.write_text(text, encoding="utf-8")
    called = call("detect", SAMPLE, option, path)
    called.refused("labels.json holds no labels")
    assert len(called.err.splitlines()) == 1
    call("detect", SAMPLE, option, tmp_path / "none.json").refused("cannot be read")


def test_labels_of_another_recording_or_detector_are_refused(
    call: Call, tmp_path: Path, labels: Path
) -> None:
    other = tmp_path / "other.csv"
    other.write_text(SAMPLE.read_text() + "\n")
    call("detect", other, "--labels", labels).refused("the labels of another recording")
    call("detect", SAMPLE, "--labels", labels, "--detector", "single-axis").refused(
        "--detector orientation"
    )
    call("detect", tmp_path / "none.csv", "--labels", labels).refused("There is no file")


def test_a_reach_without_samples_is_named_and_one_with_a_hole_is_flagged(
    call: Call, tmp_path: Path
) -> None:
    header, *rows = SAMPLE.read_text().splitlines()
    times = [float(row.split(",")[0]) for row in rows]
    middle_s = (times[0] + times[-1]) / 2
    kept = [row for row, at in zip(rows, times, strict=True) if abs(at - middle_s) > 3]
    path = tmp_path / "with-a-hole.csv"
    path.write_text("\n".join((header, *kept)) + "\n")

    def label(from_s: float, to_s: float) -> None:
        by_hand = ByHand(path, None, "orientation", "right", may_be_new=True)
        list(by_hand.keep(read_blocks(path)))
        added = Label(start_s=middle_s + from_s, end_s=middle_s + to_s, state="added")
        by_hand.save([added])

    label(-1, 1)
    times_s = f"from {middle_s - 1:.2f} to {middle_s + 1:.2f} s"
    call("detect", path, "--labels", beside(path)).refused(times_s, "no samples", "drop it")
    label(-4, -2)
    assert reaches(call, path, "--labels", beside(path))[0]["flags"] == ["gap"]
    label(-6, -4)
    assert reaches(call, path, "--labels", beside(path))[0]["flags"] == []


class _Ended(CorrectionApp):
    """An app that a signal ends right after a correction."""

    def run_here(self) -> int:
        self._screen._correction.accept(0)
        self.has_lost_terminal = True
        return 129


def test_a_correction_is_saved_although_a_signal_ends_the_screen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "labels.json"
    by_hand = ByHand(SAMPLE, path, "orientation", "right", may_be_new=True)
    found = detect_long(by_hand.keep(read_blocks(SAMPLE)))
    monkeypatch.setattr("sar_tui.app.correction.app.CorrectionApp", _Ended)
    assert by_hand.correct(Home(tmp_path / "data"), found) == 129
    states = [label.state for label in read_labels(path).reaches]
    assert states[:2] == ["accepted", "found"]


def test_labels_of_two_programs_do_not_replace_each_other(tmp_path: Path) -> None:
    path = tmp_path / "labels.json"
    one, two = (ByHand(SAMPLE, path, "orientation", "right", may_be_new=True) for _ in range(2))
    one.save([])
    one.save([])
    with pytest.raises(SourceError, match="changed by another program"):
        two.save([])


def test_where_nothing_can_be_saved_it_is_told_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def open_with(path: Path) -> None:
        ByHand(SAMPLE, path, "orientation", "right", may_be_new=True)

    with pytest.raises(Refused, match="There is no folder"):
        open_with(tmp_path / "none" / "labels.json")
    monkeypatch.setattr("os.access", lambda *_: False)
    with pytest.raises(Refused, match="Nothing can be saved in"):
        open_with(tmp_path / "labels.json")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes here")
def test_a_recording_that_is_no_file_is_refused(call: Call, tmp_path: Path, labels: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    call("detect", tmp_path / "pipe", "--labels", labels).refused("is not a file")


def test_the_screen_needs_a_terminal(call: Call) -> None:
    call("detect", SAMPLE, "--correct").refused("terminal")
    call("detect", SAMPLE, "--correct", "--json").refused("leave out --json")
    call("detect", SAMPLE, "--correct", "--one-way").refused("--one-way")
    assert not beside(SAMPLE).exists()

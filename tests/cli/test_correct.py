"""``sar-tui detect --labels`` and ``--calibrate-by``: corrected reaches are measured, and limits."""

from pathlib import Path
from typing import Any

import msgspec
import pytest

import sar_tui
from sar_tui.cli.correct import ByHand
from sar_tui.inputs.label_file import beside, read_labels
from sar_tui.inputs.recording_file import read_blocks
from sar_tui.motion.detection import detect_long
from sar_tui.motion.labels import Correction, labelled
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


def test_the_screen_needs_a_terminal(call: Call) -> None:
    call("detect", SAMPLE, "--correct").refused("terminal")
    call("detect", SAMPLE, "--correct", "--json").refused("leave out --json")
    call("detect", SAMPLE, "--correct", "--one-way").refused("--one-way")
    assert not beside(SAMPLE).exists()

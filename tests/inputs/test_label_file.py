"""Labels of reaches in files: private, whole, and never in the place of another recording's."""

import stat
from pathlib import Path

import pytest

from sar_tui.inputs.imu import SourceError
from sar_tui.inputs.label_file import LabelFile, read_labels, read_labels_of, write_labels
from sar_tui.motion.labels import Label

REACHES = (
    Label(start_s=1.25, end_s=3.5, state="moved", confidence=0.9, excursion_deg=41.0),
    Label(start_s=5.0, end_s=6.0, state="dropped", was="found"),
)


def content(hash: str = "ab", reaches: tuple[Label, ...] = REACHES) -> LabelFile:
    return LabelFile(
        file="hour.csv",
        sha256=hash,
        detector="orientation",
        detector_version="2",
        reaches=reaches,
    )


def test_labels_are_read_as_they_were_written_and_only_by_their_owner(tmp_path: Path) -> None:
    path = tmp_path / "labels.json"
    write_labels(path, content())
    assert read_labels(path) == content()
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    write_labels(path, content(reaches=REACHES[:1]))
    assert read_labels_of(path, Path("hour.csv"), "ab").reaches == REACHES[:1]
    assert [each.name for each in tmp_path.iterdir()] == ["labels.json"]


@pytest.mark.parametrize("text", ["[]", "notes", '{"file": "other.csv"}', ""])
def test_no_other_file_is_overwritten(tmp_path: Path, text: str) -> None:
    path = tmp_path / "labels.json"
    path.write_text(text)
    with pytest.raises(SourceError, match=r"labels\.json holds no labels"):
        write_labels(path, content())
    assert path.read_text() == text


def test_the_labels_of_another_recording_stay(tmp_path: Path) -> None:
    path = tmp_path / "labels.json"
    write_labels(path, content("ab"))
    with pytest.raises(SourceError, match="the labels of another recording"):
        write_labels(path, content("cd"))
    assert read_labels(path).sha256 == "ab"


def test_a_failure_of_the_disk_leaves_the_earlier_labels(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "labels.json"
    write_labels(path, content())

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("sar_tui.inputs.label_file.write_private", full)
    with pytest.raises(OSError, match="No space"):
        write_labels(path, content(reaches=()))
    assert read_labels(path) == content()

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
        detector_version="3",
        reaches=reaches,
    )


def test_labels_are_read_as_they_were_written_and_only_by_their_owner(tmp_path: Path) -> None:
    path = tmp_path / "labels.json"
    write_labels(path, content(), None)
    assert read_labels(path) == content()
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    write_labels(path, content(reaches=REACHES[:1]), content())
    assert read_labels_of(path, Path("hour.csv"), "ab").reaches == REACHES[:1]
    assert [each.name for each in tmp_path.iterdir()] == ["labels.json"]


@pytest.mark.parametrize("text", ["[]", "notes", '{"file": "other.csv"}', ""])
def test_no_other_file_is_overwritten(tmp_path: Path, text: str) -> None:
    path = tmp_path / "labels.json"
    path.write_text(text)
    with pytest.raises(SourceError, match=r"labels\.json holds no labels"):
        write_labels(path, content(), None)
    assert path.read_text() == text


@pytest.mark.parametrize("before", [None, content("cd"), content(reaches=())])
def test_labels_that_another_program_wrote_stay(tmp_path: Path, before: LabelFile | None) -> None:
    path = tmp_path / "labels.json"
    write_labels(path, content(), None)
    with pytest.raises(SourceError, match="changed by another program"):
        write_labels(path, content(reaches=REACHES[1:]), before)
    assert read_labels(path) == content()


def test_a_symbolic_link_stays(tmp_path: Path) -> None:
    path, link = tmp_path / "labels.json", tmp_path / "link.json"
    link.symlink_to(path)
    write_labels(link, content(), None)
    write_labels(link, content(reaches=()), content())
    assert link.is_symlink()
    assert read_labels(path) == content(reaches=())


def test_labels_at_an_impossible_time_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "labels.json"
    for start_s, end_s in ((1.0, 1e300), (-1e300, 1.0)):
        path.unlink(missing_ok=True)
        write_labels(path, content(reaches=(Label(start_s=start_s, end_s=end_s),)), None)
        with pytest.raises(SourceError, match="reach 1 is at a time that no recording has"):
            read_labels(path)


def test_a_failure_of_the_disk_leaves_the_earlier_labels(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "labels.json"
    write_labels(path, content(), None)

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("sar_tui.inputs.label_file.write_private", full)
    with pytest.raises(OSError, match="No space"):
        write_labels(path, content(reaches=()), content())
    assert read_labels(path) == content()

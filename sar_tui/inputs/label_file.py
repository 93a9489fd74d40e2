"""Files with the labels of a recording's reaches, as JSON."""

import hashlib
import os
from pathlib import Path
from typing import Literal

import msgspec

from sar_tui.drivers.files import write_private
from sar_tui.inputs.imu import SourceError
from sar_tui.motion.detector_names import DetectorName
from sar_tui.motion.labels import Label, mistake

LARGEST = 1 << 26
"""Largest file that is read, in bytes."""


class LabelFile(msgspec.Struct, frozen=True, kw_only=True):
    """The content of such a file.

    ``file``: the recording's name; ``sha256``: of its bytes. ``detector_version``: see
    `detection.Detector`.
    """

    labels_version: Literal[1] = 1
    file: str
    sha256: str
    detector: DetectorName
    detector_version: str
    reaches: tuple[Label, ...]


def beside(recording: Path) -> Path:
    """Return where a recording's labels are kept if no other place is named."""
    return recording.with_name(f"{recording.name}.labels.json")


def sha256(path: Path) -> str:
    """Return the hash of a recording. Raises SourceError if it cannot be read."""
    try:
        if not path.is_file() and path.exists():
            raise SourceError(f"{path} is not a file: name a recording, FILE.csv or FILE.npz.")
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except FileNotFoundError:
        raise SourceError(f"There is no file {path}.") from None
    except OSError as error:
        raise SourceError(f"{path} cannot be read: {error.strerror}.") from error


def read_labels(path: Path) -> LabelFile:
    """Read labels. Raises SourceError for any fault: one sentence with the file."""
    try:
        if path.stat().st_size > LARGEST:
            raise SourceError(f"{path} is too large for a file of labels.")
        content = msgspec.json.decode(path.read_bytes(), type=LabelFile)
    except OSError as error:
        raise SourceError(f"{path} cannot be read: {error.strerror}.") from error
    except (ValueError, RecursionError) as error:  # of msgspec, or no UTF-8
        raise SourceError(
            f"{path} holds no labels of `sar-tui detect FILE --correct`, or is damaged: move it "
            f"away, or name another file ({error})."
        ) from error
    if what := mistake(content.reaches):
        raise SourceError(f"{path} cannot be used: {what}.")
    return content


def read_labels_of(path: Path, recording: Path, hash: str) -> LabelFile:
    """Read the labels of a recording, given its hash. Raises SourceError, also if they are of
    another one.
    """
    content = read_labels(path)
    if content.sha256 != hash:
        raise SourceError(
            f"{path} holds the labels of another recording ({content.file}), or {recording} has "
            "been changed: name another file of labels with --labels."
        )
    return content


def write_labels(path: Path, content: LabelFile, before: LabelFile | None) -> None:
    """Write labels, in place of those that this program has read or written last only; until they
    are complete on the disk, the earlier ones stay.

    Args:
        path: the file.
        content: the labels.
        before: the content of the file, as far as is known; None if there was none.

    Raises SourceError if the file has any other content, and OSError.
    """
    path = path.resolve()  # so that a symbolic link stays
    if path.exists() and read_labels(path) != before:
        raise SourceError(
            f"{path} was changed by another program meanwhile, and is not overwritten: move it "
            "away to save these."
        )
    new = path.with_name(f"{path.name}.new")
    new.unlink(missing_ok=True)
    write_private(new, msgspec.json.format(msgspec.json.encode(content), indent=1))
    with new.open("rb") as file:
        os.fsync(file.fileno())
    new.replace(path)

"""``sar-tui detect --correct`` and ``--labels``: reaches that are corrected by hand."""

import contextlib
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from sar_tui.cli.common import Home, console, warn_of_git
from sar_tui.cli.errors import Refused
from sar_tui.inputs.imu import SourceError
from sar_tui.inputs.label_file import (
    LabelFile,
    beside,
    read_labels,
    read_labels_of,
    sha256,
    write_labels,
)
from sar_tui.motion.detection import DETECTORS, calibrated
from sar_tui.motion.detector_names import DetectorName
from sar_tui.motion.labelled import measured, measured_by_hand
from sar_tui.motion.labels import Correction, Label, confirmed, labelled
from sar_tui.motion.samples import join

if TYPE_CHECKING:
    from sar_tui.motion.detection import LongDetection
    from sar_tui.motion.orientation import OrientationParameters
    from sar_tui.motion.reach import Hand
    from sar_tui.motion.samples import Samples


def calibrated_by(path: Path) -> "OrientationParameters":
    """Return the limits of the person whose reaches were labelled. Raises SourceError; Refused if
    none of them was looked at.
    """
    reaches = confirmed(read_labels(path).reaches)
    if not any(label.excursion_deg for label in reaches):
        raise Refused(
            f"No reach in {path} was accepted, moved or added by hand: correct it first "
            "(sar-tui detect FILE --correct)."
        )
    return calibrated(reaches)


class ByHand:
    """The labels of a recording, in a file.

    Args:
        file: the recording.
        path: of the labels; None: beside the recording.
        detector: what finds the reaches.
        hand: the hand with the sensor.
        may_be_new: there need not be labels yet.

    Attributes:
        samples: of the recording, once they have been kept.

    Raises:
        SourceError: the labels cannot be read, or are another recording's.
        Refused: another detector found them, or new ones could not be saved.
    """

    samples: "Samples"

    def __init__(
        self,
        file: Path,
        path: Path | None,
        detector: DetectorName,
        hand: "Hand",
        *,
        may_be_new: bool,
    ) -> None:
        self._file, self._path = file, path or beside(file)
        self._is_named = path is not None
        self._detector, self._hand = detector, hand
        self._hash = sha256(file)
        self._content: LabelFile | None = None
        self._turned: dict[tuple[float, float], float | None] = {}
        self._has_written = False
        if may_be_new:
            self._check_folder()
            if not os.path.lexists(self._path):
                return
        content = read_labels_of(self._path, file, self._hash)
        if content.detector != detector:
            raise Refused(
                f"The reaches in {self._path} were found by another detector: add --detector "
                f"{content.detector}, or name another file of labels."
            )
        self._content = content

    def _check_folder(self) -> None:
        """Raise Refused if labels cannot be saved, before the work on them begins."""
        folder = self._path.parent
        if not folder.is_dir():
            raise Refused(f"There is no folder {folder} for the labels.")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise Refused(
                f"Nothing can be saved in {folder}: name a file of labels elsewhere, with --labels."
            )

    def keep(self, blocks: "Iterable[Samples]") -> "Iterator[Samples]":
        """Keep the samples that pass."""
        kept = []
        for block in blocks:
            kept.append(block)
            yield block
        self.samples = join(kept)

    def measured(self, found: "LongDetection") -> "LongDetection":
        """Return the labelled reaches in place of those that were found."""
        labels = self._content.reaches if self._content else ()
        reaches = measured(labels, found.reaches, self.samples, self._detector, self._hand)
        return found._replace(reaches=reaches)

    def correct(self, home: Home, found: "LongDetection") -> int:
        """Open the screen on which they are corrected; returns the exit code."""
        from sar_tui.app.correction.app import CorrectionApp
        from sar_tui.plugins import DEFAULT_THEME
        from sar_tui.store.interface_language import interface_language
        from sar_tui.widgets.language import app_texts
        from sar_tui.widgets.speed_chart import Speed

        labels = self._content.reaches if self._content else labelled(found.reaches)
        correction = Correction(labels, found.begins_s, found.ends_s)
        app = CorrectionApp(
            home.catalogue().theme(DEFAULT_THEME),
            app_texts(interface_language(home.folder)),
            self._file.name,
            Speed.of(self.samples),
            correction,
            self.save,
        )
        code = app.run_here()
        if correction.is_changed:  # a signal came between a correction and its being saved
            with contextlib.suppress(SourceError, OSError):
                self.save(correction.labels)
                correction.saved()
        if app.has_lost_terminal:
            return code
        out = console(error=True)
        if app.failure:
            out.print(app.failure, markup=False, soft_wrap=True)
        if correction.is_changed:
            out.print("The last corrections were not saved.", markup=False, soft_wrap=True)
        if self._has_written:
            warn_of_git(self._path)
            how = "without" if self._is_named else f"with --labels {self._path} in place of"
            out.print(
                f"The labels are in {self._path}. To measure the corrected reaches, give the same "
                f"command {how} --correct.",
                markup=False,
                soft_wrap=True,
            )
        return code

    def save(self, labels: Sequence[Label]) -> None:
        """Write labels, with how far the hand turned in those that were changed. Raises SourceError
        and OSError.
        """
        content = LabelFile(
            file=self._file.name,
            sha256=self._hash,
            detector=self._detector,
            detector_version=DETECTORS[self._detector].version,
            reaches=tuple(map(self._with_excursion, labels)),
        )
        write_labels(self._path, content, self._content)
        self._content, self._has_written = content, True

    def _with_excursion(self, label: Label) -> Label:
        if label.excursion_deg is not None or not label.counts:
            return label
        edges = label.start_s, label.end_s
        if edges not in self._turned:
            self._turned[edges] = None
            with contextlib.suppress(ValueError):  # where no samples are
                reach = measured_by_hand(label, self.samples, self._detector, self._hand)
                self._turned[edges] = reach.excursion_deg
        return msgspec.structs.replace(label, excursion_deg=self._turned[edges])

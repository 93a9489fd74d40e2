"""``sar-tui detect``: finds reaches or repetitions in a recording of a motion sensor."""

import math
from collections.abc import Iterable, Iterator
from enum import StrEnum
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import AsJson, Home, console, named_path, need_screen, print_json
from sar_tui.cli.errors import Refused
from sar_tui.cli.progress_line import Show, progress_line
from sar_tui.motion.detector_names import DetectorName

if TYPE_CHECKING:
    from sar_tui.inputs.recording_file import Units
    from sar_tui.motion.detection import LongDetection
    from sar_tui.motion.orientation import OrientationParameters
    from sar_tui.motion.reach import Reach
    from sar_tui.motion.samples import Samples

_MOST_MISSING = 10
"""A recording whose holes last longer than this many times the rest of it is refused."""

_OF_THE_WAY_BACK = (
    "turn_s", "back_s", "dwell_s", "peak_return_rad_s", "movement_units_back", "sparc_back",
    "ldlj_back", "return_error_deg",
)  # fmt: skip

_HARDLY_MOVING_RAD_S = 0.15
"""A recording of reaches has larger rates, unless rates in rad/s were taken for deg/s."""

_SLOW = (
    "The hand turns at no more than {largest} deg/s. If the file is in rad/s, leave out "
    "--rate deg/s."
)

_FLAGS = {
    "no_rest": "the hand was not still before it, so the sensor's bias is a guess",
    "gap": "samples are missing in it",
    "cut": "the recording begins or ends in it",
    "timed_out": "it lasted too long, and was ended",
    "endless": "it never came to an end",
    "reversed": "the hand turned the wrong way: check which hand it was, and how the sensor was "
    "attached",
    "low_rate": "there are few samples a second, so its boundaries are less exact",
    "saturated": "it was faster than the sensor can measure, so only its times are known",
    "moving": "the hand was still moving when it was measured",
    "clipped": "its largest values are cut off, as the sensor measures no more; only its times "
    "are known",
    "too_far": "the hand turned farther than it can: the sensor's rate is most likely in deg/s",
    "error": "the sensor reported an error",
    "samples": "too few samples to find anything in",
    "rate": "too few samples a second to find anything in",
    "analysis": "the detector failed",
    "unsure": "it may have been another movement",
    "disagree": "two detectors differ in its time by more than 20 %, so it is doubtful",
    "several": "there was more than one reach, and this is the largest",
}


def explain_flags(flags: Iterable[str]) -> Iterator[str]:
    """Yield a line for each different flag."""
    for flag in dict.fromkeys(flags):
        yield f"{flag}: {_FLAGS[flag]}" if flag in _FLAGS else flag


class Hand(StrEnum):
    """The hand with the sensor."""

    right = "right"
    left = "left"


class Rate(StrEnum):
    """Units of the angular rate in `inputs.recording_file.Units`."""

    radians = "rad/s"
    degrees = "deg/s"


class Acceleration(StrEnum):
    """Units of the acceleration in `inputs.recording_file.Units`."""

    metres = "m/s2"
    g = "g"


def detect(
    home: Home,
    file: Annotated[
        Path,
        typer.Argument(
            parser=named_path,
            metavar="FILE",
            help="FILE.csv or FILE.npz: t, wx,wy,wz, ax,ay,az.",
            show_default=False,
        ),
    ],
    detector: Annotated[
        DetectorName, typer.Option(help="How to find the reaches.")
    ] = "orientation",
    hand: Annotated[Hand, typer.Option(help="The hand with the sensor.")] = Hand.right,
    repetitions: Annotated[
        bool,
        typer.Option(
            "--repetitions",
            help="Count the repetitions of one exercise instead of finding reaches.",
        ),
    ] = False,
    one_way: Annotated[
        bool, typer.Option("--one-way", help="Find movements from rest to rest without a way back.")
    ] = False,
    calibrate: Annotated[
        int,
        typer.Option(
            "--calibrate",
            min=0,
            metavar="N",
            help="Take the first N reaches found as the person's, and leave out much smaller or "
            "longer movements; 0 for none.",
        ),
    ] = 0,
    rate: Annotated[Rate, typer.Option(help="Unit of the file's angular rates.")] = Rate.radians,
    acceleration: Annotated[
        Acceleration, typer.Option(help="Unit of its accelerations.")
    ] = Acceleration.metres,
    calibrate_by: Annotated[
        Path | None,
        typer.Option(
            "--calibrate-by",
            parser=named_path,
            metavar="LABELS",
            show_default=False,
            help="Take the reaches in a file of labels as the person's, if they were accepted, "
            "moved or added by hand.",
        ),
    ] = None,
    correct: Annotated[
        bool,
        typer.Option(
            "--correct", help="Look through the reaches on a screen, and correct them by hand."
        ),
    ] = False,
    labels: Annotated[
        Path | None,
        typer.Option(
            "--labels",
            parser=named_path,
            metavar="LABELS",
            show_default=False,
            help="The file of corrected reaches: measure these. With --correct, the file to write; "
            "default: FILE.labels.json.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Find and measure the reaches in a recording, or count the repetitions of an exercise.

    Times are in seconds on the file's own time axis.
    """
    import msgspec

    from sar_tui.inputs.imu import SourceError
    from sar_tui.inputs.recording_file import Units
    from sar_tui.motion.detection import calibrated, detect_long

    _check_together(
        one_way=one_way,
        repetitions=repetitions,
        detector=detector,
        calibrate=calibrate,
        calibrate_by=calibrate_by,
        correct=correct,
        labels=labels,
        as_json=as_json,
    )
    units = msgspec.convert({"rate": rate.value, "acceleration": acceleration.value}, Units)
    speed, by_hand = _Speed(), None
    try:
        if repetitions:
            _report_repetitions(file, units, as_json)
            return
        if correct or labels:
            from sar_tui.cli.correct import ByHand

            by_hand = ByHand(file, labels, detector, hand.value, may_be_new=correct)
        person = _person(calibrate_by)
        with progress_line("Finding reaches") as show:
            blocks = speed.watch(_told(_blocks(file, units), show))
            kept = by_hand.keep(blocks) if by_hand else blocks
            found = detect_long(kept, detector, hand.value, one_way=one_way, parameters=person)
            if calibrate:
                person = calibrated(found.reaches[:calibrate])
                blocks = _told(_blocks(file, units), show)
                found = detect_long(blocks, detector, hand.value, parameters=person)
        if by_hand and not correct:
            found = by_hand.measured(found)
    except (SourceError, ValueError) as error:
        raise Refused(str(error)) from error
    _refuse_mostly_missing(file, found.lasts_s, found.samples / found.rate_hz)
    if by_hand and correct:
        raise typer.Exit(by_hand.correct(home, found))
    if as_json:
        reaches = [_ways_out(reach) for reach in found.reaches] if one_way else found.reaches
        print_json({"detector": detector, "rate_hz": round(found.rate_hz, 3), "reaches": reaches})
    else:
        by = f"by the {detector} detector{', corrected by hand' if labels else ''}"
        _print(found, by, one_way)
        if person:
            turned = math.degrees(person.least_rad)
            limits = f"By this person's reaches: {turned:.0f}° or more, {person.longest_s:.1f} s or less."
            console().print(limits, markup=False, soft_wrap=True)
    if not found.reaches and units.rate == "deg/s" and speed.largest_rad_s < _HARDLY_MOVING_RAD_S:
        largest = f"{math.degrees(speed.largest_rad_s):.2g}"
        console(error=True).print(_SLOW.format(largest=largest), markup=False, soft_wrap=True)


def _check_together(
    *,
    one_way: bool,
    repetitions: bool,
    detector: DetectorName,
    calibrate: int,
    calibrate_by: Path | None,
    correct: bool,
    labels: Path | None,
    as_json: bool,
) -> None:
    """Raise BadParameter or Refused for options that do not go together, or not here."""
    if one_way and (repetitions or detector != "orientation"):
        raise typer.BadParameter(
            "--one-way goes neither with --repetitions nor with another detector."
        )
    if calibrate and (repetitions or one_way or detector != "orientation"):
        raise typer.BadParameter(
            "--calibrate goes neither with --repetitions, --one-way nor another detector."
        )
    if calibrate_by and (calibrate or repetitions or one_way or detector != "orientation"):
        raise typer.BadParameter(
            "--calibrate-by goes neither with --calibrate, --repetitions, --one-way nor another "
            "detector."
        )
    if (correct or labels) and (repetitions or one_way):
        raise typer.BadParameter("Corrected reaches go neither with --repetitions nor --one-way.")
    if correct and as_json:
        raise typer.BadParameter("--correct shows a screen: leave out --json.")
    if correct:
        need_screen()


def _person(labels: Path | None) -> "OrientationParameters | None":
    """Return the limits of the person whose reaches are labelled in a file; None if none is given."""
    if labels is None:
        return None
    from sar_tui.cli.correct import calibrated_by

    return calibrated_by(labels)


class _Speed:
    """The largest angular rate about one axis of the samples that pass, in rad/s."""

    largest_rad_s = 0.0

    def watch(self, blocks: "Iterable[Samples]") -> "Iterator[Samples]":
        for block in blocks:
            self.largest_rad_s = max(self.largest_rad_s, float(abs(block["rate"]).max(initial=0.0)))
            yield block


def _ways_out(reach: "Reach") -> dict[str, object]:
    """Return the fields of a reach without a way back: None for those that describe it."""
    import msgspec

    return msgspec.structs.asdict(reach) | dict.fromkeys(_OF_THE_WAY_BACK)


def _blocks(file: Path, units: "Units") -> "Iterator[Samples]":
    from sar_tui.inputs.recording_file import read_blocks, refuse_degrees

    for block in read_blocks(file, units):
        refuse_degrees(file, block)
        yield block


def _told(blocks: "Iterable[Samples]", show: Show) -> "Iterator[Samples]":
    """Yield the samples, and tell how much of the recording they are."""
    first = None
    for block in blocks:
        first = int(block["at"][0]) if first is None else first
        yield block
        minutes = (int(block["at"][-1]) - first) / 60e9
        show(f"Finding reaches, {minutes:.0f} min of the recording", 0, 0)


def _refuse_mostly_missing(file: Path, lasts_s: float, measured_s: float) -> None:
    if lasts_s > (_MOST_MISSING + 1) * measured_s:
        raise Refused(
            f"{file} lasts {lasts_s:.4g} s, but holds samples for {measured_s:.4g} s of it: "
            "check that t is in seconds, or cut it where samples are missing."
        )


def _report_repetitions(file: Path, units: "Units", as_json: bool) -> None:
    """Count repetitions in the whole file: their rhythm is that of all of it."""
    from sar_tui.inputs.recording_file import read_recording, refuse_degrees
    from sar_tui.motion.repetitions import find_repetitions
    from sar_tui.motion.samples import recording as as_recording

    with progress_line("Counting repetitions"):
        samples = read_recording(file, units)
        refuse_degrees(file, samples)
        recording = as_recording(samples, int(samples["at"][0]))
        begin_s, lasts_s = int(samples["at"][0]) / 1e9, float(recording.time_s[-1])
        _refuse_mostly_missing(file, lasts_s, len(samples) / recording.rate_hz)
        found = find_repetitions(recording)
    if as_json:
        turns_s = [round(turn + begin_s, 3) for turn in found.turns_s]
        rate_hz = round(recording.rate_hz, 3)
        print_json(
            {
                "rate_hz": rate_hz,
                "repetitions": found.count,
                "period_s": found.period_s,
                "turns_s": turns_s,
            }
        )
        return
    where = _where(lasts_s, recording.rate_hz)
    if found.period_s is None:
        sentence = (
            f"No repetitions {where}: counting needs at least two of 0.5 to 10 s each, in "
            "one rhythm."
        )
    else:
        number = "One repetition" if found.count == 1 else f"{found.count} repetitions"
        sentence = f"{number} {where}, one every {found.period_s:.2f} s."
    console().print(sentence, markup=False, soft_wrap=True)


def _print(found: "LongDetection", by: str, one_way: bool) -> None:
    from sar_tui.cli.tables import print_table

    out, reaches = console(), found.reaches
    if reaches:
        times = ("onset\ns", "turn\ns", "end\ns", "time\ns")
        numbers = (
            "reach",
            *times,
            "angle\n°",
            "out\nrad/s",
            "back\nrad/s",
            "SPARC\nout",
            "SPARC\nback",
        )
        rows = [_row(number, reach, one_way) for number, reach in enumerate(reaches, 1)]
        print_table(out, (*numbers, "flags"), rows, right=numbers)
        for line in explain_flags(flag for reach in reaches for flag in reach.flags):
            out.print(line, markup=False, soft_wrap=True)
    out.print(_sentence(found, by), markup=False, soft_wrap=True)


def _row(number: int, reach: "Reach", one_way: bool) -> list[object]:
    seconds = (reach.onset_s, None if one_way else reach.turn_s, reach.end_s, reach.reach_time_s)
    peaks = (reach.peak_extension_rad_s, None if one_way else reach.peak_return_rad_s)
    smoothness = (reach.sparc_out, reach.sparc_back)
    return [
        number,
        *(None if value is None else f"{value:.3f}" for value in seconds),
        None if reach.excursion_deg is None else f"{reach.excursion_deg:.0f}",
        *(None if value is None else f"{value:.2f}" for value in (*peaks, *smoothness)),
        ", ".join(reach.flags),
    ]


def _where(lasts_s: float, rate_hz: float) -> str:
    return f"in {lasts_s:.1f} s at {rate_hz:.4g} samples a second"


def _sentence(found: "LongDetection", by: str) -> str:
    where = f"{_where(found.lasts_s, found.rate_hz)}, {by}"
    if not found.reaches:
        return f"No reach {where}."
    times = [reach.reach_time_s for reach in found.reaches]
    if len(times) == 1:
        return f"One reach {where}: {times[0]:.3f} s."
    return (
        f"{len(times)} reaches {where}: {min(times):.3f} to {max(times):.3f} s, median "
        f"{median(times):.3f} s."
    )

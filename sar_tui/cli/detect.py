"""``sar-tui detect``: finds reaches or repetitions in a recording of a motion sensor."""

from collections.abc import Iterable, Iterator, Sequence
from enum import StrEnum
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sar_tui.cli.common import AsJson, Data, Tasks, console, named_path, print_json
from sar_tui.cli.errors import Refused
from sar_tui.motion.detector_names import STORED_NAMES, DetectorName, current_name

if TYPE_CHECKING:
    from sar_tui.motion.reach import Reach
    from sar_tui.motion.repetitions import Repetitions
    from sar_tui.motion.samples import Recording

_MOST_MISSING = 10
"""A recording whose holes last longer than this many times the rest of it is refused."""

_FLAGS = {
    "no_rest": "the hand was not still before it, so the sensor's bias is a guess",
    "gap": "samples are missing in it",
    "cut": "the recording begins or ends in it",
    "timed_out": "it lasted too long, and was ended",
    "endless": "it never came to an end",
    "reversed": "the hand turned the wrong way: check which hand it was, and how the sensor was attached",
    "low_rate": "there are few samples a second, so its boundaries are less exact",
    "saturated": "it was faster than the sensor can measure, so only its times are known",
    "moving": "the hand was still moving when it was measured",
    "error": "the sensor reported an error",
    "samples": "too few samples to find anything in",
    "rate": "too few samples a second to find anything in",
    "several": "there was more than one reach, and this is the largest",
}


def explain_flags(flags: Iterable[str]) -> Iterator[str]:
    """Yield a line for each different flag."""
    for flag in dict.fromkeys(flags):
        yield f"{flag}: {_FLAGS[flag]}" if flag in _FLAGS else flag


def read_detector(text: str) -> DetectorName:
    """Return the name of a detector, given that or an earlier one. Raises BadParameter."""
    for name in STORED_NAMES:
        if name == current_name(text):
            return name
    names = " and ".join(STORED_NAMES)
    raise typer.BadParameter(f"There is no detector {text!r}; there are {names}.")


def detector_option(help: str, *, show_default: bool = True) -> Any:
    """Return a ``--detector`` option. Like an enumeration's, but it accepts earlier names, too."""
    return typer.Option(
        metavar=f"[{'|'.join(STORED_NAMES)}]",
        parser=read_detector,
        autocompletion=lambda: list(STORED_NAMES),
        show_default=show_default,
        help=help,
    )


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
    file: Annotated[
        Path,
        typer.Argument(
            parser=named_path, metavar="FILE", help="FILE.csv or FILE.npz: t, wx,wy,wz, ax,ay,az.", show_default=False
        ),
    ],
    detector: Annotated[DetectorName, detector_option("How to find the reaches.")] = "single-axis",
    hand: Annotated[Hand, typer.Option(help="The hand with the sensor.")] = Hand.right,
    repetitions: Annotated[
        bool, typer.Option("--repetitions", help="Count the repetitions of one exercise instead of finding reaches.")
    ] = False,
    rate: Annotated[Rate, typer.Option(help="Unit of the file's angular rates.")] = Rate.radians,
    acceleration: Annotated[Acceleration, typer.Option(help="Unit of its accelerations.")] = Acceleration.metres,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Find and measure the reaches in a recording, or count the repetitions of an exercise.

    Times are in seconds on the file's own time axis.
    """
    import msgspec

    from sar_tui.inputs.imu import SourceError
    from sar_tui.inputs.recording_file import Units, read_recording, refuse_degrees
    from sar_tui.motion import detection, samples
    from sar_tui.motion.repetitions import find_repetitions

    units = msgspec.convert({"rate": rate.value, "acceleration": acceleration.value}, Units)
    try:
        measured = read_recording(file, units)
        refuse_degrees(file, measured)
        begin_ns = int(measured["at"][0])
        recording = samples.recording(measured, begin_ns)  # from 0: large times would cost precision
        _refuse_mostly_missing(file, recording)
        if repetitions:
            _report_repetitions(recording, find_repetitions(recording), begin_ns / 1e9, as_json)
            return
        found = detection.detect(recording, detector, hand=hand.value)
    except (SourceError, ValueError) as error:
        raise Refused(str(error)) from error
    reaches = [_shifted(reach, begin_ns / 1e9) for reach in found]
    if as_json:
        print_json({"detector": detector, "rate_hz": round(recording.rate_hz, 3), "reaches": reaches})
    else:
        _print(recording, reaches, detector)


def _refuse_mostly_missing(file: Path, recording: "Recording") -> None:
    time_s = recording.time_s
    lasts_s, measured_s = float(time_s[-1] - time_s[0]), len(time_s) / recording.rate_hz
    if lasts_s > (_MOST_MISSING + 1) * measured_s:
        raise Refused(
            f"{file} lasts {lasts_s:.4g} s, but holds samples for {measured_s:.4g} s of it: "
            "check that t is in seconds, or cut it where samples are missing."
        )


def _report_repetitions(recording: "Recording", found: "Repetitions", begin_s: float, as_json: bool) -> None:
    if as_json:
        turns_s = [round(turn + begin_s, 3) for turn in found.turns_s]
        rate_hz = round(recording.rate_hz, 3)
        print_json({"rate_hz": rate_hz, "repetitions": found.count, "period_s": found.period_s, "turns_s": turns_s})
        return
    where = _where(recording)
    if found.period_s is None:
        sentence = f"No repetitions {where}: counting needs at least two of 0.5 to 10 s each, in one rhythm."
    else:
        number = "One repetition" if found.count == 1 else f"{found.count} repetitions"
        sentence = f"{number} {where}, one every {found.period_s:.2f} s."
    console().print(sentence, markup=False, soft_wrap=True)


def _shifted(reach: "Reach", by_s: float) -> "Reach":
    import msgspec

    times = {name: getattr(reach, name) + by_s for name in ("onset_s", "turn_s", "end_s")}
    return msgspec.structs.replace(reach, **times)


def _print(recording: "Recording", reaches: "Sequence[Reach]", detector: str) -> None:
    from sar_tui.cli.tables import add, table

    out = console()
    if reaches:
        times = ("onset\ns", "turn\ns", "end\ns", "time\ns")
        numbers = ("reach", *times, "out\nrad/s", "back\nrad/s", "SPARC\nout", "SPARC\nback")
        made = table(*numbers, "flags", right=numbers, whole=numbers)
        made.padding = (0, 1, 0, 0)
        for number, reach in enumerate(reaches, 1):
            seconds = (reach.onset_s, reach.turn_s, reach.end_s, reach.reach_time_s)
            peaks = (reach.peak_extension_rad_s, reach.peak_return_rad_s)
            smoothness = (reach.sparc_out, reach.sparc_back)
            add(
                made,
                number,
                *(f"{value:.3f}" for value in seconds),
                *(f"{value:.2f}" for value in peaks),
                *(None if value is None else f"{value:.2f}" for value in smoothness),
                ", ".join(reach.flags),
            )
        out.print(made)
        for line in explain_flags(flag for reach in reaches for flag in reach.flags):
            out.print(line, markup=False, soft_wrap=True)
    out.print(_sentence(recording, reaches, detector), markup=False, soft_wrap=True)


def _where(recording: "Recording") -> str:
    lasts_s = float(recording.time_s[-1] - recording.time_s[0])
    return f"in {lasts_s:.1f} s at {recording.rate_hz:.4g} samples a second"


def _sentence(recording: "Recording", reaches: "Sequence[Reach]", detector: str) -> str:
    where = f"{_where(recording)}, by the {detector} detector"
    if not reaches:
        return f"No reach {where}."
    times = [reach.reach_time_s for reach in reaches]
    if len(times) == 1:
        return f"One reach {where}: {times[0]:.3f} s."
    return f"{len(times)} reaches {where}: {min(times):.3f} to {max(times):.3f} s, median {median(times):.3f} s."

"""Reaches of people found and timed: by the product, by the thesis' fixed threshold, and by a
published method, on the recordings in ``tests/data/real-reaches`` and on simulated reaches.

In the *open stream* a detector searches a whole recording. In the *known window* it searches
the time around one labelled reach, as in a session. A reach is found if it shares with a label at
least half of the longer one's time. With *calibration* the product knows the recording's first
three labelled reaches, which are not scored. *Left out* means that the limits in `GRID` that find
the reaches of all other people best are used for a person.

The published method is zero-velocity detection by the energy of the angular rate (Skog, Händel,
Nilsson & Rantakokko 2010, IEEE Trans Biomed Eng 57:2657-2666). Movements between still stretches
are ways, and two in a row that turn the hand opposite ways are a reach.
"""

import importlib.util
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.motion import as_samples
from benchmarks.real_recordings import (
    DAILY_LIFE,
    EXERCISES,
    Label,
    LabelledSet,
    is_by_eye,
    labels,
    read_daily_life,
    read_exercise,
)
from sar_tui.model.trial_types import UNSURE
from sar_tui.motion import quaternions
from sar_tui.motion.analysis import AnalysisParameters, Finding, Window, analyse
from sar_tui.motion.arrays import lengths
from sar_tui.motion.detection import apart, calibrated, detect
from sar_tui.motion.detection import find as find_all
from sar_tui.motion.detector_names import DetectorName
from sar_tui.motion.filters import usable_cutoff
from sar_tui.motion.orientation import Ends, OrientationParameters
from sar_tui.motion.plausibility import plausible
from sar_tui.motion.reach_kinds import KINDS
from sar_tui.motion.repetitions import count_repetitions
from sar_tui.motion.rest import Grid, even
from sar_tui.motion.samples import Recording
from sar_tui.motion.trajectories import simulate_reaches
from sar_tui.plugins import Catalogue

OURS: DetectorName = "orientation"
SHARED = 0.5
CALIBRATING = 3
KNOWN_SHARE, OPEN_SHARE, MOST_FALSE = 0.95, 0.9, 0.5
MOST_END_MS, MOST_TRUE_END_MS = 200.0, 80.0
LEAST_CONFIDENCE: float = Catalogue().task("reaching").Parameters().least_confidence  # type: ignore[attr-defined]
AROUND_S = 2.0
BEFORE_S, ASKED_S = 3.0, 8.0
WATCH_HZ, WATCH_COUNT = 50.0, 20
WINDOW_S, STILL_RAD_S = 0.2, 0.2
CUTOFF_HZ, BACK_S = 8.0, 1.5
LEAST_RAD, DWELL_S = math.radians(10), 5.0
GRID = tuple(
    OrientationParameters(end_rad_s=end_rad_s, return_share=return_share)
    for end_rad_s in (0.03, 0.04, 0.05, 0.06, 0.07, 0.08)
    for return_share in (0.3, 0.4, 0.5, 0.6)
)
"""Limits that may suit one person and not another: where the hand stops, and how far it comes
back.
"""
Times = tuple[float, float]
"""Onset and end of a reach, in s."""


class Kind(NamedTuple):
    """Results of one detector for one kind of movement."""

    kind: str
    detector: str
    reaches: int
    found: int
    false: int
    minutes: float
    onset_s: Sequence[float]
    end_s: Sequence[float]

    def figures(self) -> dict[str, Any]:
        """Return it with errors as median and 90th percentile of the absolute value, in ms."""
        return {
            "kind": self.kind,
            "detector": self.detector,
            "reaches": self.reaches,
            "found": self.found,
            "false_a_minute": self.false / self.minutes if self.minutes else None,
            "onset_ms": _error(self.onset_s),
            "end_ms": _error(self.end_s),
        }


def measure(quick: bool, measured: Callable[[], None]) -> dict[str, Any]:
    """Return all figures; ``measured`` is called after each recording."""
    exercises, daily = (EXERCISES[:2], DAILY_LIFE[:2]) if quick else (EXERCISES, DAILY_LIFE)
    found: dict[str, list[Kind]] = {
        name: [] for name in ("open", "people", "window", "home", "calibrated", "daily")
    }
    for name in exercises:
        for detector, find in DETECTORS.items():
            found["open"] += in_the_open(name, detector, find)
            found["window"] += in_windows(name, detector)
        found["home"] += in_windows(name, OURS, "home")
        own = [each for each in found["open"] if each.detector == OURS]
        person = f"person {name[1]}, by {'eye' if is_by_eye(name) else 'rule'}"
        found["people"] += [each._replace(kind=person) for each in own[-len(labels(name)) :]]
        found["calibrated"] += in_the_open(name, OURS, _calibrated(name), CALIBRATING)
        measured()
    for name in daily:
        recording = read_daily_life(name)
        minutes = float(recording.time_s[-1] - recording.time_s[0]) / 60
        for detector, find in DETECTORS.items():
            false = len(find(recording))
            found["daily"].append(Kind("daily life", detector, 0, 0, false, minutes, [], []))
        measured()
    simulated = [
        _simulated(kind, detector, 2 if quick else 20) for kind in KINDS for detector in DETECTORS
    ]
    measured()
    found["simulated"] = simulated
    found["left out"] = left_out(exercises, daily)
    measured()
    figures = {name: [each.figures() for each in _joined(kinds)] for name, kinds in found.items()}
    return figures | {
        "still turning": still_turning(exercises),
        "watch": _watch(),
        "unsure": {"reaches": _unsure(exercises), "daily life": _unsure_in_daily_life(daily)},
        "checks": _checks(figures),
    }


def steps(quick: bool) -> int:
    """Return the number of calls of ``measured``."""
    return 6 if quick else len(EXERCISES) + len(DAILY_LIFE) + 2


def _checks(figures: Mapping[str, Sequence[Mapping[str, Any]]]) -> dict[str, bool]:
    """Return whether the product's own detector reaches its goals, by name."""
    ours = {
        part: next(each for each in reversed(rows) if each["detector"] == OURS)
        for part, rows in figures.items()
    }
    found = {part: ours[part]["found"] / ours[part]["reaches"] for part in ("open", "window")}
    ends = {part: abs((ours[part]["end_ms"] or [math.inf])[0]) for part in ("open", "simulated")}
    return {
        f"reaches: at least {KNOWN_SHARE:.0%} found in a known window": found["window"]
        >= KNOWN_SHARE,
        f"reaches: at least {OPEN_SHARE:.0%} found in an open stream": found["open"] >= OPEN_SHARE,
        f"reaches: at most {MOST_FALSE:g} a minute in daily life": ours["daily"]["false_a_minute"]
        <= MOST_FALSE,
        f"reaches: median error of ends at most {MOST_END_MS:g} ms": ends["open"] <= MOST_END_MS,
        f"reaches: that of simulated ones at most {MOST_TRUE_END_MS:g} ms": ends["simulated"]
        <= MOST_TRUE_END_MS,
    }


# --- detectors


def _by(detector: DetectorName) -> Callable[[Recording], list[Times]]:
    return lambda recording: [(reach.onset_s, reach.end_s) for reach in detect(recording, detector)]


def _calibrated(name: str) -> Callable[[Recording], list[Times]]:
    """Return our detector with the parameters of the person whose first reaches in a recording are
    known.
    """
    first = labels(name)[0].reaches[:CALIBRATING]

    def find(recording: Recording) -> list[Times]:
        known = [
            reach
            for reach in detect(recording)
            if any(is_same((reach.onset_s, reach.end_s), label) for label in first)
        ]
        return [
            (reach.onset_s, reach.end_s) for reach in detect(recording, OURS, calibrated(known))
        ]

    return find


def zero_velocity(recording: Recording) -> list[Times]:
    """Return reaches by zero-velocity detection, in order of time."""
    grid = even(recording)
    rate = grid.rate - np.median(grid.rate, axis=0)
    size = max(1, round(WINDOW_S * grid.rate_hz))
    energy = np.convolve((rate**2).sum(axis=1), np.ones(size) / size, "same")
    moving = np.concatenate(([False], energy > STILL_RAD_S**2, [False]))
    edges = np.flatnonzero(np.diff(moving.astype(int)))
    orientation = quaternions.integrate(rate, 1.0 / grid.rate_hz)
    ways = []
    for first, stop in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        turned = quaternions.multiply(
            quaternions.conjugate(orientation[first]), orientation[stop - 1]
        )
        vector = quaternions.to_rotation(turned[None])[0]
        if float(lengths(vector[None])[0]) >= LEAST_RAD:
            ways.append((float(grid.time_s[first]), float(grid.time_s[stop - 1]), vector))
    found: list[Times] = []
    for (out_s, arrival_s, out), (departure_s, end_s, back) in pairwise(ways):
        is_next = not found or out_s >= found[-1][1]
        if is_next and departure_s - arrival_s <= DWELL_S and float(out @ back) < 0:
            found.append((out_s, end_s))
    return found


DETECTORS: Mapping[str, Callable[[Recording], list[Times]]] = {
    "orientation": _by("orientation"),
    "fixed-threshold": _by("fixed-threshold"),
    "zero-velocity": zero_velocity,
}


# --- recordings


def in_the_open(
    name: str, detector: str, find: Callable[[Recording], list[Times]], skipped: int = 0
) -> Iterator[Kind]:
    """Yield what a detector finds in each set of a recording, searched as a whole, without the
    first reaches of the first set.
    """
    found = find(read_exercise(name))
    for part in labels(name):
        reaches = part.reaches[skipped:]
        from_s = _ends(reaches[0])[0] - AROUND_S / 2 if skipped else part.from_s
        skipped = 0
        inside = [times for times in found if from_s <= sum(times) / 2 <= part.to_s]
        pairs = [(times, label) for label in reaches for times in inside if is_same(times, label)]
        known = {times for times, _ in pairs}
        false = [
            times
            for times in inside
            if times not in known and not any(overlap(times, each) > 0 for each in part.doubtful)
        ]
        yield Kind(
            _kind(name, part.manner), detector, len(reaches), len({label for _, label in pairs}),
            len(false), (part.to_s - from_s) / 60,
            [times[0] - label.onset_s for times, label in pairs],
            [times[1] - label.end_s for times, label in pairs],
        )  # fmt: skip


def in_windows(name: str, detector: str, ends: Ends = "still") -> Iterator[Kind]:
    """Yield what a detector finds in the windows around the reaches of each set."""
    recording = read_exercise(name)
    for part in labels(name):
        pairs = []
        for label, window in windows(part):
            times = _in_window(recording, detector, window, ends)
            if times and is_same(times, label):
                pairs.append((times, label))
        yield Kind(
            _kind(name, part.manner), detector, len(part.reaches), len(pairs), 0, 0.0,
            [times[0] - label.onset_s for times, label in pairs],
            [times[1] - label.end_s for times, label in pairs],
        )  # fmt: skip


def still_turning(exercises: Sequence[str]) -> dict[str, dict[str, float]]:
    """Return by person how fast the hand turns about any axis at the labelled ends, in the median:
    in rad/s, and as a share of the largest rate of that way back.

    A rule that looks at one axis ends a reach while the hand turns about others.
    """
    speeds: dict[str, list[tuple[float, float]]] = {}
    for name in exercises:
        grid = even(read_exercise(name))
        speed = lengths(grid.unbiased(1.0).spectrum.below(usable_cutoff(CUTOFF_HZ, grid.rate_hz)))
        for label in (label for part in labels(name) for label in part.reaches):
            if math.isnan(label.end_s):
                continue
            first, last = np.searchsorted(grid.time_s, (label.end_s - BACK_S, label.end_s)).tolist()
            way_back = speed[first : last + 1]
            speeds.setdefault(name[1], []).append(
                (float(way_back[-1]), float(way_back[-1] / way_back.max()))
            )
    return {
        person: dict(zip(("rad_s", "share"), np.median(each, axis=0).tolist(), strict=True))
        for person, each in sorted(speeds.items())
    }


def left_out(exercises: Sequence[str], daily: Sequence[str]) -> list[Kind]:
    """Return what our detector finds of each person with the limits that suit all other people
    best.

    Those find the most reaches with the fewest false ones (F1), daily life included; of equals, the
    ones with the smallest errors of ends.
    """
    grids = {name: even(read_exercise(name)) for name in exercises}
    lives = [(read_daily_life(name), even(read_daily_life(name))) for name in daily]
    results: list[tuple[OrientationParameters, dict[str, list[Kind]], int]] = []
    for limits in GRID:
        kinds = {
            name: [*in_the_open(name, OURS, partial(_by_limits, limits, grid))]
            for name, grid in grids.items()
        }
        false = sum(len(_by_limits(limits, grid, life)) for life, grid in lives)
        results.append((limits, kinds, false))
    found = []
    for person in sorted({name[1] for name in exercises}):
        limits, kinds, _ = max(results, key=lambda result: _fit(result[1], result[2], person))
        text = f"person {person}: {limits.end_rad_s:g} rad/s, {limits.return_share:g}"
        for name, own in kinds.items():
            found += [each._replace(kind=text) for each in own if name[1] == person]
    return found


def _by_limits(limits: OrientationParameters, grid: Grid, recording: Recording) -> list[Times]:
    likely = plausible(find_all(recording, OURS, limits, grid=grid))
    return [(bounds.onset_s, bounds.end_s) for bounds in apart(likely.reaches)]


def _fit(kinds: Mapping[str, Sequence[Kind]], false: int, person: str) -> tuple[float, float]:
    """Return how well limits suit all people but one."""
    others = [each for name, own in kinds.items() if name[1] != person for each in own]
    total = _sum("others", OURS, others)
    ends_s = np.abs([off for off in total.end_s if not math.isnan(off)])
    finds = total.found + total.false + false
    return 2 * total.found / (total.reaches + finds), -float(np.median(ends_s))


class Asked(NamedTuple):
    """A window in which a reach is asked for, and when, in s."""

    from_s: float
    started_s: float
    to_s: float


def windows(part: LabelledSet) -> Iterator[tuple[Label, Asked]]:
    """Yield each labelled reach, and a window around it that holds nothing of its neighbours."""
    for index, label in enumerate(part.reaches):
        onset_s, end_s = _ends(label)
        before = _ends(part.reaches[index - 1])[1] if index else -math.inf
        after = _ends(part.reaches[index + 1])[0] if index + 1 < len(part.reaches) else math.inf
        from_s = max(onset_s - AROUND_S, min(before, onset_s - 0.1))
        yield label, Asked(from_s, onset_s, min(end_s + AROUND_S, max(after, end_s + 0.1)))


def _in_window(
    recording: Recording, detector: str, asked: Asked, ends: Ends = "still"
) -> Times | None:
    """Return the reach that a detector finds in a window; None without one."""
    if detector == "zero-velocity":
        inside = (recording.time_s >= asked.from_s) & (recording.time_s <= asked.to_s)
        found = zero_velocity(Recording(recording.time_s[inside], recording.rate[inside]))
        return max(found, key=lambda times: times[1] - times[0], default=None)
    finding = _finding(recording, detector, asked, ends)
    if finding.onset_ns is None or finding.end_ns is None:
        return None
    return finding.onset_ns / 1e9, finding.end_ns / 1e9


def _finding(recording: Recording, detector: str, asked: Asked, ends: Ends = "still") -> Finding:
    """Return what a session would find in a window, in the recording's own time."""
    samples = as_samples(recording)
    samples["at"] += round(float(recording.time_s[0]) * 1e9) - samples["at"][0]
    window = Window(
        from_ns=round(asked.from_s * 1e9),
        started_ns=round(asked.started_s * 1e9),
        to_ns=round(asked.to_s * 1e9),
    )
    # as in a session: it begins at home
    orientation = OrientationParameters(home_s=0.0, ends=ends)
    parameters = AnalysisParameters(
        detector=detector,  # type: ignore[arg-type]
        orientation=orientation,
        least_confidence=LEAST_CONFIDENCE,
    )
    return analyse(samples, window, parameters)


class Unsure(NamedTuple):
    """Number of movements that were found in windows, and of those of which the detector is not
    sure.
    """

    found: int
    unsure: int


def _unsure(exercises: Sequence[str]) -> Unsure:
    """Count the labelled reaches that a session would not score."""
    asked = ((name, window) for name in exercises for part in labels(name)
             for _, window in windows(part))  # fmt: skip
    return _counted(_finding(read_exercise(name), OURS, window) for name, window in asked)


def _unsure_in_daily_life(daily: Sequence[str]) -> Unsure:
    """Count what is found where a reach is asked for, and somebody does something else: sits,
    stands up, walks.
    """
    return _counted(
        _finding(recording, OURS, Asked(at_s - BEFORE_S, at_s, at_s + ASKED_S - BEFORE_S))
        for recording in map(read_daily_life, daily)
        for at_s in np.arange(
            recording.time_s[0] + BEFORE_S, recording.time_s[-1] - ASKED_S, ASKED_S
        )
    )


def _counted(findings: Iterable[Finding]) -> Unsure:
    flags = [found.flags for found in findings if found.onset_ns is not None]
    return Unsure(len(flags), sum(UNSURE in each for each in flags))


def _simulated(kind: str, detector: str, people: int) -> Kind:
    """Return what a detector finds of simulated reaches, three of each person."""
    reaches = found = false = 0
    minutes = 0.0
    onset_s: list[float] = []
    end_s: list[float] = []
    for seed in range(people):
        made = simulate_reaches(kind, 1000 + seed, count=3)
        times_found = DETECTORS[detector](made.recording)
        pairs = [
            (times, truth)
            for truth in made.truth
            for times in times_found
            if overlap(times, truth) >= SHARED
        ]
        reaches += len(made.truth)
        found += len(pairs)
        false += len(times_found) - len(pairs)
        minutes += float(made.recording.time_s[-1]) / 60
        onset_s += [times[0] - truth[0] for times, truth in pairs]
        end_s += [times[1] - truth[1] for times, truth in pairs]
    return Kind(kind, detector, reaches, found, false, minutes, onset_s, end_s)


def _watch() -> dict[str, Any] | None:
    """Return how well sets of twenty repetitions with a watch are counted, by the repetition counter
    and as reaches that were asked for; None without them.
    """
    package = importlib.util.find_spec("seglearn")
    if package is None or package.origin is None:
        return None
    path = Path(package.origin).parent / "data" / "watch_dataset.npy"
    data = np.load(path, allow_pickle=True).item()
    counts: dict[str, list[int]] = {"repetitions": [], OURS: []}
    for samples in data["X"]:
        rate, acceleration = samples[:, 3:], samples[:, :3]
        counts["repetitions"].append(count_repetitions(rate, acceleration, WATCH_HZ).count)
        whole = Recording(np.arange(len(rate)) / WATCH_HZ, rate, acceleration)
        counts[OURS].append(len(find_all(whole).reaches))
    return {
        by: {
            "sets": len(each),
            "exact": sum(count == WATCH_COUNT for count in each),
            "within_one": sum(abs(count - WATCH_COUNT) <= 1 for count in each),
        }
        for by, each in counts.items()
    }


# --- figures


def _kind(name: str, manner: str) -> str:
    return f"arm {name.split('_')[1][1:]}, {manner}"


def _ends(label: Label) -> Times:
    """Return onset and end of a label, the next best time where one is not known."""
    onset_s = label.arrival_s - 1.0 if math.isnan(label.onset_s) else label.onset_s
    end_s = label.departure_s + 1.0 if math.isnan(label.end_s) else label.end_s
    if math.isnan(end_s):
        end_s = label.arrival_s + 1.5
    return onset_s, end_s


def overlap(one: Times, other: Times) -> float:
    """Return the time that two reaches share, as a part of the longer one."""
    shared_s = min(one[1], other[1]) - max(one[0], other[0])
    return shared_s / max(one[1] - one[0], other[1] - other[0])


def is_same(times: Times, label: Label) -> bool:
    """Return True if a reach that was found is the labelled one."""
    return overlap(times, _ends(label)) >= SHARED


def _joined(kinds: Sequence[Kind]) -> list[Kind]:
    """Return a row for each kind and detector, and for all kinds together."""
    names = sorted({each.kind for each in kinds})
    rows = []
    for kind in [*names, "all"] if len(names) > 1 else names:
        for detector in DETECTORS:
            same = [
                each for each in kinds if each.detector == detector and kind in (each.kind, "all")
            ]
            if same:
                rows.append(_sum(kind, detector, same))
    return rows


def _sum(kind: str, detector: str, kinds: Sequence[Kind]) -> Kind:
    return Kind(
        kind, detector, sum(each.reaches for each in kinds), sum(each.found for each in kinds),
        sum(each.false for each in kinds), sum(each.minutes for each in kinds),
        [off for each in kinds for off in each.onset_s],
        [off for each in kinds for off in each.end_s],
    )  # fmt: skip


def _error(off_s: Sequence[float]) -> list[float] | None:
    """Return the median error and the 90th percentile of its absolute value, in ms."""
    known = 1000 * np.array([off for off in off_s if not math.isnan(off)])
    if not len(known):
        return None
    return [float(np.median(known)), float(np.percentile(np.abs(known), 90))]

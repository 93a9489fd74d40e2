"""Detection and measurement of the reaches in a recording; one of any length a window at a time, in
bounded memory.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, NamedTuple, Protocol

import msgspec
import numpy as np

from sar_tui.motion import fixed_threshold, one_way, orientation, single_axis
from sar_tui.motion.measures import measure
from sar_tui.motion.plausibility import LEAST_RAD, plausible
from sar_tui.motion.reach import Bounds, Detected, Hand, Reach
from sar_tui.motion.rest import Grid
from sar_tui.motion.samples import Recording, Samples, join, recording

WINDOW = 1 << 18
"""Largest number of samples that are analysed as a whole: 17 minutes at 250 a second."""
CONTEXT_S = 30.0
"""Time around a window's own part that is analysed with it: longer than a reach, with rests that
show the bias.
"""
SHORTEST_S = 1.0
"""A shorter stretch of samples holds no reach."""
HOLE_S = 60.0
"""A longer hole ends a window."""
SHORTEST_WINDOW_S = 6 * CONTEXT_S
"""A window is at least this long, so that each is well ahead of the one before."""
_NS = 1e9


class LongDetection(NamedTuple):
    """The reaches in a recording, in order of time. All times are its own, in s."""

    reaches: tuple[Reach, ...]
    rate_hz: float
    begins_s: float
    ends_s: float
    samples: int

    @property
    def lasts_s(self) -> float:
        """Time from the first to the last sample."""
        return self.ends_s - self.begins_s


class _Windows:
    """The samples that are not analysed yet, and the reaches found before them."""

    def __init__(self, detect: Callable[..., tuple[Reach, ...]], window: int) -> None:
        self._detect = detect
        self._size = window
        self._lasts_ns = 0
        self._waiting: list[Samples] = []
        self._own_from_s = -np.inf
        self._reaches: list[Reach] = []
        self._rates: list[float] = []
        self._first: int | None = None
        self._last = 0
        self._count = 0

    def add(self, block: Samples) -> None:
        """Add samples, and analyse all windows that are full."""
        if self._first is None:
            self._first = int(block["at"][0])
            lasts_ns = self._size * float(np.median(np.diff(block["at"])))
            self._lasts_ns = round(max(lasts_ns, SHORTEST_WINDOW_S * _NS))
        self._waiting.append(block)
        self._last = int(block["at"][-1])
        self._count += len(block)
        while self._last - int(self._waiting[0]["at"][0]) > self._lasts_ns:
            self._waiting = [self._analyse_window(join(self._waiting))]

    def _analyse_window(self, samples: Samples) -> Samples:
        """Analyse the first window of samples, up to its first hole; return the samples for the
        next.
        """
        at = samples["at"]
        size = int(np.searchsorted(at, int(at[0]) + self._lasts_ns, side="right"))
        holes = np.flatnonzero(np.diff(at[: size + 1]) > HOLE_S * _NS)
        if len(holes):
            size = int(holes[0]) + 1
            self._take_stretch(samples[:size])
            self._own_from_s = -np.inf
            return samples[size:]
        cut_s = self._take_window(samples[:size])
        self._own_from_s = max(cut_s, self._reaches[-1].end_s if self._reaches else cut_s)
        return samples[np.searchsorted(at, round((cut_s - CONTEXT_S) * _NS)) :]

    def finish(self) -> LongDetection:
        """Analyse the rest, and return the result."""
        if self._first is None:
            raise ValueError("There are no samples.")
        self._take_stretch(join(self._waiting))
        rate_hz = float(np.median(self._rates))
        return LongDetection(
            tuple(self._reaches), rate_hz, self._first / _NS, self._last / _NS, self._count
        )

    def _take_stretch(self, samples: Samples) -> None:
        """Take all reaches in samples that none follow."""
        if not self._rates or samples["at"][-1] - samples["at"][0] >= SHORTEST_S * _NS:
            self._reaches += self._found(samples)

    def _take_window(self, samples: Samples) -> float:
        """Take the reaches up to a rest in the second half of a window, and return the time of that
        rest.
        """
        found = self._found(samples)
        first_s, last_s = int(samples["at"][0]) / _NS, int(samples["at"][-1]) / _NS
        cut_s = _longest_rest(found, (first_s + last_s) / 2, last_s - CONTEXT_S)
        self._reaches += [reach for reach in found if reach.onset_s < cut_s]
        return cut_s

    def _found(self, samples: Samples) -> list[Reach]:
        """Return the reaches that no earlier window has had."""
        origin_ns = int(samples["at"][0])
        window = recording(samples, origin_ns)  # from 0: large times would cost precision
        self._rates.append(window.rate_hz)
        origin_s = origin_ns / _NS
        found = self._detect(window, since_s=self._own_from_s - origin_s)
        return [_shifted(reach, origin_s) for reach in found]


class Detector(NamedTuple):
    """A way to find reaches.

    ``version`` changes whenever its results may change. ``is_quiet``: True if `detect` leaves out
    what it finds in daily life (`plausibility.plausible`).
    """

    version: str
    parameters: type[msgspec.Struct]
    find: Callable[[Recording, Any, Hand, Grid | None], Detected]
    is_quiet: bool = False


DETECTORS: dict[str, Detector] = {
    "orientation": Detector(
        "3", orientation.OrientationParameters, orientation.find, is_quiet=True
    ),
    "single-axis": Detector("2", single_axis.SingleAxisParameters, single_axis.find),
    "fixed-threshold": Detector(
        "1", fixed_threshold.FixedThresholdParameters, fixed_threshold.find
    ),
}


MEET_S = 0.1
"""Two reaches without a rest between them overlap by less than this, as either's boundary is an
estimate.
"""


def detect(
    recording: Recording,
    detector: str = "orientation",
    parameters: msgspec.Struct | None = None,
    hand: Hand = "right",
    since_s: float = -math.inf,
) -> tuple[Reach, ...]:
    """Return the reaches in a recording of any content, in order of time. They do not overlap.

    A window of a session, in which a reach was asked for, is analysed by `analysis.analyse`, which
    judges less.

    Args:
        recording: the samples; best with at least a second of rest before the reach.
        detector: a name in ``DETECTORS``, or one of its earlier names.
        parameters: of that detector's type, such as those of a person (`calibrated`); its defaults
            if None, and then a smaller turn than `plausibility.LEAST_RAD` is no reach.
        hand: the hand with the sensor.
        since_s: reaches that begin earlier are left out, as they were found in an earlier part.

    Raises ValueError for an unknown detector, another detector's parameters, or too low a sample
    rate.
    """
    found = find(recording, detector, parameters, hand)
    likely = found
    if DETECTORS[detector].is_quiet:
        least_rad = LEAST_RAD if parameters is None else getattr(parameters, "least_rad", LEAST_RAD)
        likely = plausible(found, least_rad)
    return measure(likely._replace(reaches=apart(likely.reaches, since_s)), recording)


LEAST_SHARE, LONGEST_SHARE = 1 / 3, 3.0
"""A person's reaches turn the hand by at least the first share of the smallest calibrating one, and
last at most the second share of the longest.
"""


class Known(Protocol):
    """A reach of a person: one that was found, or one that was labelled."""

    @property
    def excursion_deg(self) -> float | None: ...

    @property
    def reach_time_s(self) -> float: ...


def calibrated(reaches: Sequence[Known]) -> orientation.OrientationParameters:
    """Return the parameters for a person, of whom some reaches are known; three are enough.

    Raises ValueError for none that was measured.
    """
    turned_deg = [reach.excursion_deg for reach in reaches if reach.excursion_deg]
    if not turned_deg:
        raise ValueError("There is no reach to calibrate with.")
    return orientation.OrientationParameters(
        least_rad=LEAST_SHARE * math.radians(min(turned_deg)),
        longest_s=LONGEST_SHARE * max(reach.reach_time_s for reach in reaches),
    )


def detect_one_way(recording: Recording, since_s: float = -math.inf) -> tuple[Reach, ...]:
    """Return the movements in a recording from rest to rest without a way back (`one_way.find`), as
    `detect`.
    """
    found = one_way.find(recording)
    return measure(found._replace(reaches=apart(found.reaches, since_s)), recording)


def find(
    recording: Recording,
    detector: str = "orientation",
    parameters: msgspec.Struct | None = None,
    hand: Hand = "right",
    grid: Grid | None = None,
) -> Detected:
    """Return the boundaries of all excursions that may be a reach, without measuring them: much
    faster.

    Arguments and errors are those of `detect`.

    ``grid``: the recording's even grid (`rest.even`), if it is known.
    """
    chosen = DETECTORS.get(detector)
    if chosen is None:
        raise ValueError(
            f"There is no detector named {detector!r}; there are: {', '.join(DETECTORS)}."
        )
    if parameters is not None and not isinstance(parameters, chosen.parameters):
        raise ValueError(
            f"The detector {detector!r} takes {chosen.parameters.__name__}, not "
            f"{type(parameters).__name__}."
        )
    return chosen.find(recording, parameters, hand, grid)


def apart(reaches: Iterable[Bounds], since_s: float = -math.inf) -> tuple[Bounds, ...]:
    """Return reaches in order of time, such that each begins at the end of the one before, or
    later.

    One that begins a little too early begins at that end instead. One that begins much earlier is
    the same movement found again, and is left out.

    Args:
        reaches: in any order.
        since_s: end of the last reach before them, in s.
    """
    kept: list[Bounds] = []
    for bounds in sorted(reaches, key=lambda bounds: bounds.onset_s):
        if bounds.onset_s < since_s - MEET_S or bounds.arrival_s <= since_s:
            continue
        kept.append(msgspec.structs.replace(bounds, onset_s=max(bounds.onset_s, since_s)))
        since_s = max(since_s, bounds.end_s)
    return tuple(kept)


def detect_long(
    blocks: Iterable[Samples],
    detector: str = "orientation",
    hand: Hand = "right",
    window: int = WINDOW,
    *,
    one_way: bool = False,
    parameters: msgspec.Struct | None = None,
) -> LongDetection:
    """Find and measure the reaches in samples that come in blocks.

    A recording that lasts as long as ``window`` samples, or less, is analysed as a whole, as
    `detection.detect` does. A longer one is analysed in windows that overlap, cut where no reach
    is: each has its own bias, noise and tremor. A movement that has no rest in a whole window is
    cut off at its end.

    With ``one_way`` it finds movements without a way back (`detection.detect_one_way`), whatever
    the detector. ``parameters`` are as for `detection.detect`.

    Raises ValueError for no samples, and as `detection.detect`.
    """
    of_any_kind = partial(detect, detector=detector, parameters=parameters, hand=hand)
    windows = _Windows(detect_one_way if one_way else of_any_kind, window)
    for block in blocks:
        windows.add(block)
    return windows.finish()


def _longest_rest(reaches: Sequence[Reach], from_s: float, to_s: float) -> float:
    """Return the middle of the longest time without a reach between two times; the second one if
    there is no such.
    """
    begins = [*(min(max(reach.onset_s, from_s), to_s) for reach in reaches), to_s]
    ends = [from_s, *(min(max(reach.end_s, from_s), to_s) for reach in reaches)]
    end, begin = max(zip(ends, begins, strict=True), key=lambda rest: rest[1] - rest[0])
    return (end + begin) / 2 if begin > end else to_s


def _shifted(reach: Reach, by_s: float) -> Reach:
    times = {name: getattr(reach, name) + by_s for name in ("onset_s", "turn_s", "end_s")}
    return msgspec.structs.replace(reach, **times)

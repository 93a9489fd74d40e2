"""Detection of reaches in a recording of any length, a window at a time, in bounded memory."""

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import NamedTuple

import msgspec
import numpy as np

from sar_tui.motion.detection import detect, detect_one_way
from sar_tui.motion.reach import Hand, Reach
from sar_tui.motion.samples import Samples, join, recording

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


def detect_long(
    blocks: Iterable[Samples],
    detector: str = "orientation",
    hand: Hand = "right",
    window: int = WINDOW,
    *,
    one_way: bool = False,
) -> LongDetection:
    """Find and measure the reaches in samples that come in blocks.

    A recording that lasts as long as ``window`` samples, or less, is analysed as a whole, as
    `detection.detect` does. A longer one is analysed in windows that overlap, cut where no reach
    is: each has its own bias, noise and tremor. A movement that has no rest in a whole window is
    cut off at its end.

    With ``one_way`` it finds movements without a way back (`detection.detect_one_way`), whatever
    the detector.

    Raises ValueError for no samples, and as `detection.detect`.
    """
    windows = _Windows(
        detect_one_way if one_way else partial(detect, detector=detector, hand=hand), window
    )
    for block in blocks:
        windows.add(block)
    return windows.finish()


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

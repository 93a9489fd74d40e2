"""The state of a hand after samples that are known beforehand, as those of a simulated hand are."""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from sar_tui.motion.filters import LEAST_RATE_HZ
from sar_tui.motion.samples import Samples
from sar_tui.motion.segmentation import segment
from sar_tui.motion.single_axis import SingleAxisParameters


class Hand(NamedTuple):
    """State of a hand: its time at rest, s; True if it has been out and back; the start of its
    movement, s.
    """

    rested_s: float
    reached: bool
    began_s: float | None


STILL = Hand(0.0, False, None)
"""A hand whose movement is not known."""


class Foreseen:
    """Samples that came and samples that are to come, segmented at once.

    Args:
        samples: dtype SAMPLE.
        known: number of samples that came.
        rate_hz: samples per second; below 20 nothing is known of the hand's movement.
        parameters: as for ``single_axis.find``.
    """

    def __init__(
        self, samples: Samples, known: int, rate_hz: float, parameters: SingleAxisParameters
    ) -> None:
        self._samples = samples
        self._known = known
        usable = rate_hz >= LEAST_RATE_HZ
        rate = samples["rate"].astype(float)
        self._found = segment(samples["at"] / 1e9, rate, rate_hz, parameters) if usable else None

    def continues_with(self, samples: Samples) -> bool:
        """Return True if these are the samples that come next."""
        expected = self._samples[self._known : self._known + len(samples)]
        return expected.tobytes() == samples.tobytes()

    def take(self, count: int, since_s: float) -> Hand:
        """Return the state of the hand after the next ``count`` samples, which have come; reached
        since a time (s).
        """
        (hand,) = self.hands((count,), since_s)
        self._known += count
        return hand

    def at_rest(self, counts: Sequence[int], rest_s: float) -> list[int]:
        """Return those of some numbers of samples to come after which the hand has rested for a
        time (s).
        """
        if self._found is None:
            return []
        found = np.array(counts)
        return found[self._found.still_for_s[self._known - 1 + found] >= rest_s].tolist()  # type: ignore[no-any-return]

    def hands(self, counts: Sequence[int], since_s: float) -> Iterator[Hand]:
        """Yield the state of the hand after each of some numbers of samples to come; reached since
        a time (s).
        """
        if self._found is None:
            yield from [STILL] * len(counts)
            return
        index = self._known - 1 + np.array(counts, dtype=np.int_)
        reached = self._found.has_reached(index, since_s)
        began = [
            None if math.isnan(began_s) else began_s
            for began_s in self._found.began_s[index].tolist()
        ]
        yield from map(Hand, self._found.still_for_s[index].tolist(), reached.tolist(), began)

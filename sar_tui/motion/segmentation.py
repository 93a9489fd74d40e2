"""Segmentation of a whole stretch of samples at once: the same as the Segmenter's, in a sixth of
its time or less.

The filters and the properties of rest are calculated for all samples together, and threshold
crossings are searched for in arrays, so that code runs once per change instead of once per sample.
The results of such calculations differ from the Segmenter's in the last digits. Only comparisons
follow from them, and times of samples: wherever a comparison is closer than ``CLOSE``, the
Segmenter itself decides on the whole stretch.
"""

import math
from bisect import bisect_right
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from sar_tui.motion.filters import lowpass, usable_cutoff
from sar_tui.motion.rest import SLOW_HZ, STEADY_RAD_S, STILL_RAD_S
from sar_tui.motion.samples import Floats
from sar_tui.motion.segmenter import (
    BACK,
    BLOCK_S,
    CLEAR,
    EARLY_S,
    LONGEST_STEP_S,
    NEWEST,
    SPREADS,
    Segmenter,
)
from sar_tui.motion.single_axis import SingleAxisParameters

CLOSE = 1e-9
"""Difference, in rad/s or rad, below which two values count as too close to compare: rounding makes
1e-12 at most.
"""
STRETCH = 256
"""Number of samples that are searched at a time for a threshold crossing."""
NEVER = -math.inf


class Segmentation(NamedTuple):
    """The Segmenter's attributes after each of n samples; arrays of shape (n,), in s.

    ``still_for_s``: time at rest, 0 in movement. ``began_s``: start of the present or last
    movement; NaN before the first. ``returned_s``: when the hand came back in that movement; -inf
    if it has not.
    """

    still_for_s: Floats
    began_s: Floats
    returned_s: Floats

    def has_reached(self, index: npt.NDArray[np.int_], since_s: float) -> npt.NDArray[np.bool_]:
        """Return for some samples whether the hand has come back since then, as
        `Segmenter.has_reached`.
        """
        return (self.returned_s[index] > since_s) & (self.began_s[index] > since_s - EARLY_S)


def segment(
    time_s: Floats,
    rate: Floats,
    rate_hz: float,
    parameters: SingleAxisParameters | None = None,
    close: float = CLOSE,
) -> Segmentation:
    """Segment samples: time in s, shape (n,), rising; angular rate in rad/s, shape (n, 3).

    Args:
        time_s, rate: the samples.
        rate_hz: samples per second; below 20 raises ValueError.
        parameters: as for ``single_axis.find``.
        close: difference below which the Segmenter decides.
    """
    parameters = parameters or SingleAxisParameters()
    if len(time_s) and np.isfinite(rate).all():
        try:
            return _Search(time_s, rate, rate_hz, parameters, close).found()
        except _TooClose:
            pass
    return _one_by_one(time_s, rate, rate_hz, parameters)


def _one_by_one(
    time_s: Floats, rate: Floats, rate_hz: float, parameters: SingleAxisParameters
) -> Segmentation:
    segmenter = Segmenter(rate_hz, parameters)
    found = np.empty((3, len(time_s)))
    for index in range(len(time_s)):
        segmenter.push(time_s[index : index + 1], rate[index : index + 1])
        began_s = math.nan if segmenter.began_s is None else segmenter.began_s
        returned_s = segmenter.returned_s if segmenter.returned else NEVER
        found[:, index] = segmenter.still_for_s, began_s, returned_s
    return Segmentation(*found)


class _TooClose(Exception):
    """Rounding might decide a comparison."""


class _Rests(NamedTuple):
    """Properties of a rest that could be learnt at the end of each block of a tenth of a second, by
    number of block.
    """

    level: list[list[float]]
    fast_floor: list[float]
    slow_floor: list[float]
    spread: list[float]


class _Ahead(NamedTuple):
    """Biases and noise up to before sample ``stop``, provided that the hand goes on to move or to
    rest.

    From each of the samples ``starts`` on: a bias, and the noise floor of the filter that is used.
    """

    starts: list[int]
    biases: list[list[float]]
    floors: list[float]
    stop: int

    def at(self, index: int) -> int:
        """Return which of them is valid at a sample."""
        return bisect_right(self.starts, index) - 1

    def within(self, first: int, last: int) -> tuple[Floats, Floats]:
        """Return bias and noise floor of samples ``first`` to before ``last``: of shape (n, 3) and
        (n,), or one.
        """
        one, other = self.at(first), self.at(last - 1)
        biases, floors = (
            np.array(self.biases[one : other + 1]),
            np.array(self.floors[one : other + 1]),
        )
        if one == other:
            return biases, floors
        bounds = [first, *self.starts[one + 1 : other + 1], last]
        index = np.repeat(
            np.arange(len(floors)), [stop - start for start, stop in pairwise(bounds)]
        )
        return biases[index], floors[index]


class _Search:
    """The state of the Segmenter at a sample, and the search for the next sample at which it
    changes.

    Attributes are those of the Segmenter, without underscores.
    """

    def __init__(
        self,
        time_s: Floats,
        rate: Floats,
        rate_hz: float,
        parameters: SingleAxisParameters,
        close: float,
    ) -> None:
        self.time_s, self.parameters, self.close = time_s, parameters, close
        self.fast = lowpass(rate, rate_hz, usable_cutoff(parameters.cutoff_hz, rate_hz))
        self.slow = lowpass(lowpass(rate, rate_hz, SLOW_HZ), rate_hz, SLOW_HZ)
        self.step_s = np.minimum(np.diff(time_s, prepend=time_s[0]), LONGEST_STEP_S)
        self.size = max(1, round(BLOCK_S * rate_hz))
        self.window = max(2, round(parameters.rest_s / BLOCK_S))
        self.rests = self._rests()
        self.moved = [False] * (len(time_s) // self.size + 1)
        self.bias: list[float] = self.slow[0].tolist()
        self.fast_floor = self.slow_floor = 0.0
        self.rested = self.moving = self.shaking = False
        self.moving_s, self.moving_block = 0.0, 0
        self.began_s: float | None = None
        self.returned_s = NEVER
        self.stopped_s = float(time_s[0])
        self.turned = np.zeros(3)
        self.farthest = 0.0
        self.changes: list[tuple[int, float, float, float]] = []

    def found(self) -> Segmentation:
        """Return the segmentation of all samples."""
        index = 0
        self._note(0)
        ahead = self._look_ahead(0)
        change = self._crossing(ahead, 0)
        while True:
            self._turn(ahead, index, change)
            if block_starts := ahead.at(change):
                self._use((ahead.starts[block_starts] + 1) // self.size - 1)
            if change == len(self.time_s):
                break
            index = change
            if change == ahead.stop:
                self._learn(index)
                ahead = self._look_ahead(index)
                change = self._crossing(ahead, index)
                if change > index:
                    self._note(index)
            else:
                self._switch(index)
                self._note(index)
                ahead = self._look_ahead(index)
                change = self._crossing(ahead, index + 1)
        if self.moving:
            self._check_duration(index)
        return self._segmentation()

    def _rests(self) -> _Rests:
        """Calculate what could be learnt at the end of each block, from the blocks of a rest before
        the newest.
        """
        blocks = len(self.time_s) // self.size
        fast, slow = (
            x[: blocks * self.size].reshape(blocks, self.size, 3) for x in (self.fast, self.slow)
        )
        sums = np.zeros((blocks + 1, 8))
        np.cumsum(fast.sum(axis=1), axis=0, out=sums[1:, 0:3])
        np.cumsum(slow.sum(axis=1), axis=0, out=sums[1:, 3:6])
        np.cumsum((fast**2).sum(axis=(1, 2)), out=sums[1:, 6])
        np.cumsum((slow**2).sum(axis=(1, 2)), out=sums[1:, 7])
        mean = np.full((blocks, 8), math.inf)
        first = self.window + NEWEST - 1
        mean[first:] = (sums[self.window : -NEWEST] - sums[: -NEWEST - self.window]) / (
            self.window * self.size
        )
        with np.errstate(invalid="ignore"):
            variance = mean[:, 6:] - np.column_stack(
                ((mean[:, :3] ** 2).sum(axis=1), (mean[:, 3:6] ** 2).sum(axis=1))
            )
        spreads = np.sqrt(np.maximum(variance, 0.0))
        spreads[:first] = math.inf
        fast_spread, slow_spread = spreads.T
        return _Rests(
            mean[:, 3:6].tolist(), (SPREADS * fast_spread).tolist(),
            (SPREADS * slow_spread).tolist(), slow_spread.tolist(),
        )  # fmt: skip

    # --- the bias

    def _look_ahead(self, index: int) -> _Ahead:
        """Return biases and noise after a sample, up to the first rest, or to where the other
        filter must be used.
        """
        shaking, bias = self.shaking, self.bias
        ahead = _Ahead(
            [index], [bias], [self.slow_floor if shaking else self.fast_floor], len(self.time_s)
        )
        for block in range(
            max((index + 1) // self.size, self.window + NEWEST - 1), len(self.rests.spread)
        ):
            end = (block + 1) * self.size - 1
            if end <= index or not self._may_learn(block, bias):
                continue
            if not self.rested or self._is_shaking(block) != shaking:
                return ahead._replace(stop=end)
            bias = self.rests.level[block]
            ahead.starts.append(end)
            ahead.biases.append(bias)
            ahead.floors.append(
                (self.rests.slow_floor if shaking else self.rests.fast_floor)[block]
            )
        return ahead

    def _may_learn(self, block: int, bias: list[float]) -> bool:
        """Return True if the bias is learnt at the end of a block, when it was ``bias``."""
        last = block - NEWEST
        if not self._is_less(self.rests.spread[block], STILL_RAD_S, or_equal=True):
            return False
        if not self.rested:
            return True
        if any(self.moved[last - self.window + 1 : last + 1]) or (
            self.moving and last >= self.moving_block
        ):
            return False
        return self._is_less(math.dist(self.rests.level[block], bias), STEADY_RAD_S, or_equal=True)

    def _learn(self, end: int) -> None:
        """Learn bias and noise at the last sample of a block."""
        block = (end + 1) // self.size - 1
        if not self.rested:
            if self.moving:
                self._mark_moved(end)
                self.moving, self.stopped_s = False, float(self.time_s[end])
            self.began_s, self.returned_s = None, NEVER
            self.turned, self.farthest = np.zeros(3), 0.0
        self.rested = True
        self._use(block)

    def _use(self, block: int) -> None:
        self.bias = self.rests.level[block]
        self.fast_floor, self.slow_floor = (
            self.rests.fast_floor[block],
            self.rests.slow_floor[block],
        )
        self.shaking = self._is_shaking(block)

    def _is_shaking(self, block: int) -> bool:
        return self._is_less(
            CLEAR * self.parameters.begin_rad_s, 2.0 * self.rests.fast_floor[block]
        )

    # --- movement

    def _crossing(self, ahead: _Ahead, index: int) -> int:
        """Return the first sample from ``index`` on at which the hand begins or stops;
        ``ahead.stop`` if at none.
        """
        for first in range(index, ahead.stop, STRETCH):
            last = min(first + STRETCH, ahead.stop)
            bias, floor = ahead.within(first, last)
            filtered = (self.slow if self.shaking else self.fast)[first:last] - bias
            speed = np.sqrt(np.einsum("ij,ij->i", filtered, filtered))
            if self.moving:
                excess = np.maximum(self.parameters.end_rad_s, 1.2 * floor) - speed
            else:
                excess = speed - np.maximum(self.parameters.begin_rad_s, 2.0 * floor)
            near = int((excess > -self.close).argmax())
            if excess[near] > self.close:
                return first + near
            if excess[near] > -self.close:
                raise _TooClose
        return ahead.stop

    def _switch(self, index: int) -> None:
        """Begin or stop moving at a sample."""
        now = float(self.time_s[index])
        if self.moving:
            self._check_duration(index)
            self._mark_moved(index)
            self.moving, self.stopped_s = False, now
            return
        over = self.returned_s > NEVER or self.farthest < self.parameters.least_rad
        rested_s = self.parameters.pause_s if over else self.parameters.dwell_s
        still_for_s = float(self.time_s[index - 1]) - self.stopped_s if index else 0.0
        if self.began_s is None or still_for_s > rested_s:
            self.began_s, self.returned_s = now, NEVER
            self.turned, self.farthest = np.zeros(3), 0.0
        self.moving, self.moving_s, self.moving_block = True, now, (index + 1) // self.size

    def _mark_moved(self, last: int) -> None:
        """Note the blocks of a movement that the Segmenter still sees at sample ``last``."""
        for block in range(self.moving_block, last // self.size + 1):
            self.moved[block] = True

    def _check_duration(self, index: int) -> None:
        """Leave movements that may be too long to be real to the Segmenter."""
        if self.time_s[index] - self.moving_s > self.parameters.longest_s - 1.0:
            raise _TooClose

    def _turn(self, ahead: _Ahead, first: int, last: int) -> None:
        """Track the angle of the hand over samples ``first`` to before ``last``: it is back when
        little is left.
        """
        if self.began_s is None or self.returned_s > NEVER:
            return
        if not self.moving:
            rest_s = self.time_s[first:last] - self.stopped_s
            last = first + int(np.searchsorted(rest_s, BLOCK_S, "right"))
        if first == last:
            return
        bias, _ = ahead.within(first, last)
        steps = (self.slow[first:last] - bias) * self.step_s[first:last, None]
        turned = self.turned + np.cumsum(steps, axis=0)
        angle = np.sqrt(np.einsum("ij,ij->i", turned, turned))
        farthest = np.maximum(np.maximum.accumulate(angle), self.farthest)
        far = farthest - self.parameters.least_rad
        back = np.minimum(far, BACK * farthest - angle)
        near = int((back > -self.close).argmax())
        if abs(back[near]) <= self.close:
            raise _TooClose
        self.turned, self.farthest = turned[-1], float(farthest[-1])
        if back[near] > self.close:
            self.returned_s = float(self.time_s[first + near])
            self._note(first + near)

    def _is_less(self, one: float, other: float, *, or_equal: bool = False) -> bool:
        """Compare two values; raise _TooClose if rounding might decide."""
        if abs(one - other) <= self.close:
            raise _TooClose
        return one < other

    # --- the result

    def _note(self, index: int) -> None:
        """Note the state from a sample on."""
        began_s = math.nan if self.began_s is None else self.began_s
        stopped_s = math.nan if self.moving else self.stopped_s
        self.changes.append((index, stopped_s, began_s, self.returned_s))

    def _segmentation(self) -> Segmentation:
        starts, *states = zip(*self.changes, strict=True)
        lengths = np.diff([*starts, len(self.time_s)])
        stopped_s, began_s, returned_s = (np.repeat(state, lengths) for state in states)
        return Segmentation(np.nan_to_num(self.time_s - stopped_s, nan=0.0), began_s, returned_s)

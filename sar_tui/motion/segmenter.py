"""Online segmentation of movement: movement or rest, time at rest, and return to the start; and the
rest from which a reach starts.
"""

import math
from collections import deque

from sar_tui.motion import quaternions
from sar_tui.motion.arrays import changes, lengths, order_statistic
from sar_tui.motion.filters import LEAST_RATE_HZ, Lowpass, Vector, usable_cutoff
from sar_tui.motion.orientation import OrientationParameters
from sar_tui.motion.rest import SLOW_HZ, STEADY_RAD_S, STILL_RAD_S, even
from sar_tui.motion.samples import Floats, Samples, recording
from sar_tui.motion.single_axis import SingleAxisParameters

BLOCK_S = 0.1
"""Duration of a block of samples."""
BACK = 0.35
"""The hand is back when its angle is below this share of the largest."""
LONGEST_STEP_S = 0.1
"""Longest time between two samples over which the angle is integrated."""
CLEAR = 1.5
"""If twice the noise exceeds the begin threshold by this factor, the slower filter is used."""
EARLY_S = 0.5
"""A movement may begin this long before the start of a trial."""
NEWEST = 2
"""Number of newest blocks that are not used as rest: they may hold the start of a movement."""
SPREADS = 2.0
"""Noise floor, in standard deviations at rest."""
SHORTEST_S = 0.1
"""A shorter rest is a turn."""


class _Block:
    """Sums over a tenth of a second: fast and slow rates, and whether the hand moved."""

    __slots__ = ("count", "fast", "moved", "slow", "squares")

    def __init__(self) -> None:
        self.count = 0
        self.fast = [0.0, 0.0, 0.0]
        self.slow = [0.0, 0.0, 0.0]
        self.squares = [0.0, 0.0]
        self.moved = False


class Segmenter:
    """Distinguishes movement from rest, sample by sample; for ending a trial, not for timing a
    reach.

    Its state after a sample does not depend on the blocks in which samples arrive. Its filters
    delay it by tens of milliseconds, or by up to half a second if tremor or noise require a slower
    one.

    Args:
        rate_hz: samples per second; below 20 raises ValueError.
        parameters: as for ``single_axis.find``.

    Attributes:
        moving: True while the hand moves.
        still_for_s: time since it stopped; 0 while it moves.
        began_s: start of the present or last movement, pauses at the target included; None before
            the first.
        returned: True if that movement has gone out and come back.
        returned_s: when a hand last came back; -inf if none has.
    """

    def __init__(self, rate_hz: float, parameters: SingleAxisParameters | None = None) -> None:
        self.parameters = parameters or SingleAxisParameters()
        cutoff = usable_cutoff(self.parameters.cutoff_hz, rate_hz)
        self.moving = False
        self.still_for_s = 0.0
        self.began_s: float | None = None
        self.returned = False
        self._fast = Lowpass(cutoff, rate_hz)
        self._slow = Lowpass(SLOW_HZ, rate_hz)
        self._slower = Lowpass(SLOW_HZ, rate_hz)
        self._block_size = max(1, round(BLOCK_S * rate_hz))
        self._blocks: deque[_Block] = deque(
            maxlen=NEWEST + max(2, round(self.parameters.rest_s / BLOCK_S))
        )
        self._block = _Block()
        self._bias: Vector | None = None
        self._rested = False
        self._fast_floor = self._slow_floor = 0.0
        self._last_s: float | None = None
        self._stopped_s: float | None = None
        self._moving_s = 0.0
        self._turned = [0.0, 0.0, 0.0]
        self._farthest = 0.0
        self.returned_s = -math.inf

    def has_reached(self, since_s: float) -> bool:
        """Return True if the hand has come back since then, in a movement that began at most 0.5 s
        before.
        """
        return (
            self.returned
            and self.returned_s > since_s
            and (self.began_s or 0.0) > since_s - EARLY_S
        )

    def push(self, time_s: Floats, rate: Floats) -> None:
        """Add samples: time in s, shape (n,); angular rate in rad/s, shape (n, 3). Non-finite ones
        are skipped.
        """
        samples = [
            (now, (x, y, z))
            for now, (x, y, z) in zip(time_s.tolist(), rate.tolist(), strict=True)
            if math.isfinite(x + y + z)
        ]
        rates = [vector for _, vector in samples]
        fast, slow = self._fast.filter(rates), self._slower.filter(self._slow.filter(rates))
        for (now, _), quick, calm in zip(samples, fast, slow, strict=True):
            self._sample(now, quick, calm)

    def _sample(self, now: float, fast: Vector, slow: Vector) -> None:
        step = 0.0 if self._last_s is None else min(now - self._last_s, LONGEST_STEP_S)
        self._last_s = now
        self._bias = self._bias or slow
        self._collect(fast, slow)
        bias = self._bias
        fast_speed, slow_speed = math.dist(fast, bias), math.dist(slow, bias)
        least = self.parameters.begin_rad_s
        shaking = 2.0 * self._fast_floor > CLEAR * least
        speed, floor = (slow_speed, self._slow_floor) if shaking else (fast_speed, self._fast_floor)
        if self.moving:
            self._moving_s += step
            if (
                speed < max(self.parameters.end_rad_s, 1.2 * floor)
                or self._moving_s > self.parameters.longest_s
            ):
                self._stop(now)
        elif speed > max(least, 2.0 * floor) and self._moving_s <= self.parameters.longest_s:
            self._begin(now)
        if not self.moving:
            self._stopped_s = now if self._stopped_s is None else self._stopped_s
            self.still_for_s = now - self._stopped_s
        self._turn(slow, bias, step)

    def _forget(self) -> None:
        """Reset to the state before the first movement."""
        self.moving, self.began_s, self.returned = False, None, False
        self._turned, self._farthest = [0.0, 0.0, 0.0], 0.0

    def _begin(self, now: float) -> None:
        """Start moving: a new movement after a rest, or after a long rest at the target."""
        over = self.returned or self._farthest < self.parameters.least_rad
        rested_s = self.parameters.pause_s if over else self.parameters.dwell_s
        if self.began_s is None or self.still_for_s > rested_s:
            self.began_s, self.returned = now, False
            self._turned, self._farthest = [0.0, 0.0, 0.0], 0.0
        self.moving, self.still_for_s, self._stopped_s, self._moving_s = True, 0.0, None, 0.0

    def _stop(self, now: float) -> None:
        """Stop moving; after a movement too long to be real, the bias is learnt again at the next
        rest.
        """
        self.moving, self._stopped_s = False, now
        if self._moving_s > self.parameters.longest_s:
            self._rested = False
        else:
            self._moving_s = 0.0

    def _turn(self, slow: Vector, bias: Vector, step: float) -> None:
        """Track the angle of the hand: it is back when little of the largest angle is left."""
        if (
            self.began_s is None
            or self.returned
            or (not self.moving and self.still_for_s > BLOCK_S)
        ):
            return
        for axis in range(3):
            self._turned[axis] += (slow[axis] - bias[axis]) * step
        angle = math.hypot(*self._turned)
        self._farthest = max(self._farthest, angle)
        if self._farthest >= self.parameters.least_rad and angle < BACK * self._farthest:
            self.returned, self.returned_s = True, self._last_s or 0.0

    def _collect(self, fast: Vector, slow: Vector) -> None:
        """Add a sample to the blocks, and learn bias and noise from the last ``rest_s`` when a
        block is full.
        """
        block = self._block
        block.count += 1
        block.moved = block.moved or self.moving
        (x, y, z), (u, v, w) = fast, slow
        block.fast[0] += x
        block.fast[1] += y
        block.fast[2] += z
        block.slow[0] += u
        block.slow[1] += v
        block.slow[2] += w
        # from left to right: rounding is the same
        block.squares[0] = block.squares[0] + x * x + y * y + z * z
        block.squares[1] = block.squares[1] + u * u + v * v + w * w
        if block.count < self._block_size:
            return
        self._blocks.append(block)
        self._block = _Block()
        if len(self._blocks) == self._blocks.maxlen:
            self._learn([*self._blocks][:-NEWEST])

    def _learn(self, blocks: list[_Block]) -> None:
        """Learn bias and noise from blocks, if the slow rate was steady in them and near the known
        bias.

        At the first rest, earlier movement is forgotten: its bias was only a guess.
        """
        level, (fast, slow) = _level(blocks), _spreads(blocks)
        if slow > STILL_RAD_S:
            return
        known = self._rested and self._bias is not None
        if known and (
            any(block.moved for block in blocks)
            or math.dist(level, self._bias or level) > STEADY_RAD_S
        ):
            return
        if not known:
            self._forget()
        self._bias, self._rested, self._moving_s = level, True, 0.0
        self._fast_floor, self._slow_floor = SPREADS * fast, SPREADS * slow


def _level(blocks: list[_Block]) -> Vector:
    """Return the mean of the slow rate."""
    count = sum(block.count for block in blocks)
    x, y, z = (sum(block.slow[axis] for block in blocks) / count for axis in range(3))
    return x, y, z


def _spreads(blocks: list[_Block]) -> tuple[float, float]:
    """Return the standard deviations of the fast and the slow rate, all axes together."""
    count = sum(block.count for block in blocks)
    fast = sum((sum(block.fast[axis] for block in blocks) / count) ** 2 for axis in range(3))
    slow = sum(level * level for level in _level(blocks))
    squares = [sum(block.squares[which] for block in blocks) / count for which in (0, 1)]
    return math.sqrt(max(0.0, squares[0] - fast)), math.sqrt(max(0.0, squares[1] - slow))


def home_since(samples: Samples, at: int, parameters: OrientationParameters) -> int | None:
    """Return when the hand came to the rest from which it starts at about ``at``; both in ns.

    None if the samples before that rest hold no movement that a detector could take for a part of
    the reach (it turned the hand by less than ``parameters.least_rad``), or if the hand did not
    rest.

    Args:
        samples: the newest samples, dtype SAMPLE.
        at: when the participant started the trial.
        parameters: definitions of rest and of a reach.
    """
    if len(samples) < 2:
        return None
    origin = int(samples["at"][0])
    grid = even(recording(samples, origin))
    if len(grid.time_s) < 2 or grid.rate_hz < LEAST_RATE_HZ:
        return None
    rest, rate, spectrum = grid.unbiased(parameters.rest_s)
    slow = lengths(spectrum.below(SLOW_HZ, rest.tremor_hz))
    still = slow <= max(parameters.end_rad_s, 1.2 * order_statistic(slow[rest.still], 0.99))
    edges = changes(still)
    at_s = (at - origin) / 1e9
    homes = [
        first
        for first, stop in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
        if stop - first >= SHORTEST_S * grid.rate_hz
        and grid.time_s[first] < at_s
        and grid.time_s[stop - 1] >= at_s - EARLY_S
    ]
    if not homes:
        return None
    orientation = quaternions.integrate(rate[: homes[-1] + 1], 1.0 / grid.rate_hz)
    turned = quaternions.angle(
        quaternions.multiply(quaternions.conjugate(orientation[-1]), orientation)
    )
    return (
        origin + round(float(grid.time_s[homes[-1]]) * 1e9)
        if turned.max() >= parameters.least_rad
        else None
    )

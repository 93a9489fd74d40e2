"""A wrist's orientation over minutes, made of shifts, rhythms and sway, and what a motion sensor on
it measures.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sar_tui.motion.quaternions import conjugate, from_rotation, multiply, rotate, to_rotation
from sar_tui.motion.samples import Floats, Recording
from sar_tui.motion.synthesis import ACCELERATION_NOISE_M_S2, FOREARM_M, GRAVITY_M_S2

Angles = tuple[float, float, float]
"""Turn about the vertical, elevation of the forearm, and its rotation (pronation): in degrees, or
in m for a place.
"""

WANDER_HZ = 0.3
"""Frequency and amplitude of a rhythm wander below this frequency."""
RAMP_S = 0.4
"""Time over which a rhythm swells and fades."""
NOISE_RAD_S = math.radians(0.2)
"""Noise of a good gyroscope."""
BIAS_RAD_S = math.radians(1.0)
"""Standard deviation of its bias on each axis."""
BIAS_WALK_RAD_S = math.radians(0.01)
"""Standard deviation of what the bias changes by in a second."""


class Trip(NamedTuple):
    """A movement out to a place and back to where it began, from its onset to its end, in s: a
    reach by its shape.
    """

    from_s: float
    to_s: float


class WristMotion:
    """The trajectory of a wrist, which movements are added to.

    The sensor's x points to the right, its y along the forearm to the fingers and its z out of the
    back of the hand. The orientation takes them to the room's: the turn about the vertical, then
    the elevation about x, then the forearm's rotation about y. With all three 0 the forearm lies
    flat, palm down.

    Args:
        lasts_s: duration.
        rate_hz: samples per second.
        generator: source of all randomness.
    """

    def __init__(self, lasts_s: float, rate_hz: float, generator: np.random.Generator) -> None:
        self.lasts_s = lasts_s
        self.generator = generator
        self.trips: list[Trip] = []
        self._rate_hz = rate_hz
        count = round(lasts_s * rate_hz)
        # The trajectory is known half a step before each sample and half a step after it.
        self._edge_s = (np.arange(count + 1) - 0.5) / rate_hz
        self._angles = np.zeros((count + 1, 3))
        self._elbow = np.zeros((count + 1, 3))
        self._wander = self._band_noise(0.0, WANDER_HZ, 2)

    def rest(self, posture: Angles) -> None:
        """Add a constant posture, in degrees."""
        self._angles += np.radians(posture)

    def sway(self, sd: Angles, from_hz: float, to_hz: float) -> None:
        """Add random movement in a band of frequencies all the time, of standard deviations in
        degrees.
        """
        self._angles += np.radians(sd) * self._band_noise(from_hz, to_hz, 3)

    def shift(
        self, at_s: float, by: Angles, takes_s: float, *, elbow_m: Angles = (0.0, 0.0, 0.0)
    ) -> None:
        """Add a minimum-jerk change of posture by some degrees, and of the elbow's place by some m,
        that stays.
        """
        first = self._index(at_s)
        share = np.clip((self._edge_s[first:, None] - at_s) / takes_s, 0.0, 1.0)
        done = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
        self._angles[first:] += np.radians(by) * done
        self._elbow[first:] += np.asarray(elbow_m) * done

    def rhythm(
        self,
        from_s: float,
        to_s: float,
        hz: float,
        swing: Angles,
        *,
        harmonics: Sequence[float] = (1.0,),
        lags: Angles = (0.0, 0.0, 0.0),
        frequency_cv: float = 0.03,
        amplitude_cv: float = 0.15,
        bounce_m: Angles = (0.0, 0.0, 0.0),
        bounce_hz: float = 0.0,
    ) -> None:
        """Add a rhythm whose frequency and amplitude wander; it swells and fades over ``RAMP_S``.

        Args:
            from_s: its start.
            to_s: its end.
            hz: its mean frequency.
            swing: amplitude of each angle, in degrees.
            harmonics: relative amplitude of the first, the second, ... harmonic; each begins at a
                phase of its own.
            lags: delay of each angle as a share of the period.
            frequency_cv: coefficient of variation of the frequency.
            amplitude_cv: coefficient of variation of the amplitude.
            bounce_m: amplitude of the elbow's movement along each axis of the room, in m.
            bounce_hz: the frequency of that, in proportion to ``hz``.
        """
        part = slice(self._index(from_s), self._index(to_s))
        time_s = self._edge_s[part]
        if not len(time_s):
            return
        pace = hz * (1.0 + frequency_cv * self._wander[part, 0])
        phase = 2 * math.pi * np.cumsum(pace)[:, None] / self._rate_hz
        ramp_s = min(RAMP_S, (to_s - from_s) / 3)
        swell = np.clip(np.minimum(time_s - from_s, to_s - time_s) / ramp_s, 0.0, 1.0)
        size = (
            np.sin(swell * math.pi / 2) ** 2
            * np.maximum(0.0, 1.0 + amplitude_cv * self._wander[part, 1])
        )[:, None]
        starts = self.generator.uniform(0.0, 2 * math.pi, len(harmonics))
        starts[0] = 0.0
        for number, (share, start) in enumerate(zip(harmonics, starts, strict=True), start=1):
            turned = number * (phase - 2 * math.pi * np.asarray(lags)) + start
            self._angles[part] += np.radians(swing) * share * size * np.sin(turned)
        if bounce_hz:
            self._elbow[part] += np.asarray(bounce_m) * size * np.sin(phase * bounce_hz / hz)

    def measured(self) -> Recording:
        """Return what a sensor with bias and noise measures of it, with an accelerometer."""
        orientation = self._orientation()
        turned = to_rotation(multiply(conjugate(orientation[:-1]), orientation[1:]))
        rate = turned * self._rate_hz
        middle = multiply(orientation[:-1], from_rotation(turned / 2.0))
        wrist = self._elbow + rotate(orientation, np.array([0.0, FOREARM_M, 0.0]))
        speed = np.diff(wrist, axis=0) * self._rate_hz
        own = np.gradient(speed, 1.0 / self._rate_hz, axis=0)
        felt = rotate(conjugate(middle), own + np.array([0.0, 0.0, GRAVITY_M_S2]))
        noise = self.generator.standard_normal((len(rate), 6))
        walk = np.cumsum(self.generator.standard_normal((len(rate), 3)), axis=0) / math.sqrt(
            self._rate_hz
        )
        bias = BIAS_RAD_S * self.generator.standard_normal(3) + BIAS_WALK_RAD_S * walk
        return Recording(
            time_s=np.arange(len(rate)) / self._rate_hz,
            rate=rate + bias + NOISE_RAD_S * noise[:, :3],
            acceleration=felt + ACCELERATION_NOISE_M_S2 * noise[:, 3:],
        )

    def _orientation(self) -> Floats:
        """Return the orientation at each edge of a sample, shape (n + 1, 4)."""
        turn, elevation, rotation = (
            from_rotation(self._angles[:, [column]] * axis)
            for column, axis in enumerate(
                np.array([(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])
            )
        )
        return multiply(turn, multiply(elevation, rotation))

    def _band_noise(self, from_hz: float, to_hz: float, columns: int) -> Floats:
        """Return noise between two frequencies of standard deviation 1, shape (n + 1, columns)."""
        white = self.generator.standard_normal((len(self._edge_s), columns))
        spectrum = np.fft.rfft(white, axis=0)
        frequency = np.fft.rfftfreq(len(white), 1.0 / self._rate_hz)
        spectrum[(frequency < from_hz) | (frequency > to_hz)] = 0.0
        spectrum[0] = 0.0
        noise: Floats = np.fft.irfft(spectrum, len(white), axis=0)
        noise /= np.maximum(noise.std(axis=0), 1e-12)
        return noise

    def _index(self, at_s: float) -> int:
        return int(np.searchsorted(self._edge_s, at_s))

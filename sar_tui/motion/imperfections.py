"""Imperfections of simulated sensors, and of the hands they are on."""

import math
from typing import Any

import msgspec
import numpy as np

from sar_tui.motion.samples import Floats

Vector = tuple[float, float, float]


class Imperfections(msgspec.Struct, frozen=True, kw_only=True):
    """Imperfections of a gyroscope and of the hand it is on.

    Args:
        noise_rad_s: standard deviation of the noise of each axis, rad/s.
        bias_rad_s: output of each axis at rest, rad/s.
        drift_rad_s_per_s: growth of the bias of every axis, rad/s per second.
        tremor_hz: frequency of the hand's tremor, Hz.
        tremor_rad_s: its amplitude about its main axis, rad/s; half of that across it. At rest and
            in movement.
        lost: share of samples that never arrive, 0 to 1.
    """

    noise_rad_s: float = 0.0
    bias_rad_s: Vector = (0.0, 0.0, 0.0)
    drift_rad_s_per_s: float = 0.0
    tremor_hz: float = 5.0
    tremor_rad_s: float = 0.0
    lost: float = 0.0


class StrappedSensor(Imperfections, frozen=True, kw_only=True):
    """Imperfections of a sensor of both kinds on a body that moves as one, and of its clock.

    Args:
        action_tremor_hz: frequency of a tremor that comes with movement only, the holding of a
            target included, Hz.
        action_tremor_rad_s: its amplitude, as ``tremor_rad_s``.
        range_rad_s: larger rates about an axis are reported as this, without notice.
        acceleration_noise_m_s2: standard deviation of the accelerometer's noise, m/s².
        acceleration_bias_m_s2: its error at rest, m/s².
        jitter_s: standard deviation of the error of the samples' times, s. Their order is kept.
    """

    action_tremor_hz: float = 7.0
    action_tremor_rad_s: float = 0.0
    range_rad_s: float = math.inf
    acceleration_noise_m_s2: float = 0.0
    acceleration_bias_m_s2: Vector = (0.0, 0.0, 0.0)
    jitter_s: float = 0.0


PERFECT = StrappedSensor()


def ordinary(generator: np.random.Generator, shaking: bool = False) -> StrappedSensor:
    """Return a usual sensor on a usual hand; if ``shaking``, with tremor at rest and in action.

    The tremors have the frequencies that Deuschl et al. (1998, Mov Disord 13 suppl 3:2-23) give for
    Parkinson's disease at rest (4 to 6 Hz) and for other tremor in action.
    """
    degree = math.radians(1.0)
    return StrappedSensor(
        noise_rad_s=degree * generator.uniform(0.1, 0.5),
        bias_rad_s=_vector(generator, 2.0 * degree),
        drift_rad_s_per_s=degree * generator.uniform(-0.005, 0.005),
        tremor_hz=generator.uniform(4.0, 6.0),
        tremor_rad_s=generator.uniform(0.05, 0.25) if shaking else 0.0,
        action_tremor_hz=generator.uniform(6.0, 9.0),
        action_tremor_rad_s=generator.uniform(0.05, 0.2)
        if shaking
        else generator.uniform(0.0, 0.04),
        acceleration_noise_m_s2=generator.uniform(0.02, 0.05),
        acceleration_bias_m_s2=_vector(generator, 0.1),
        jitter_s=0.0002,
    )


def _vector(generator: np.random.Generator, largest: float) -> Vector:
    x, y, z = generator.uniform(-largest, largest, 3)
    return float(x), float(y), float(z)


class Measured(msgspec.Struct, frozen=True):
    """Output of a sensor: times (s, shape (n,)), angular rate (rad/s, (n, 3)) and acceleration
    (m/s², (n, 3)).
    """

    time_s: Floats
    rate: Floats
    acceleration: Floats


def spoil(
    true: Measured, sensor: StrappedSensor, rate_hz: float, generator: np.random.Generator
) -> Measured:
    """Return the output of an imperfect sensor in place of a perfect one's. Tremor is part of the
    movement itself.
    """
    time_s, count = true.time_s, len(true.time_s)
    rate = true.rate + np.asarray(sensor.bias_rad_s) + sensor.drift_rad_s_per_s * time_s[:, None]
    rate += sensor.noise_rad_s * generator.standard_normal((count, 3))
    acceleration = true.acceleration + np.asarray(sensor.acceleration_bias_m_s2)
    acceleration += sensor.acceleration_noise_m_s2 * generator.standard_normal((count, 3))
    jitter = np.clip(
        sensor.jitter_s * generator.standard_normal(count), -0.4 / rate_hz, 0.4 / rate_hz
    )
    kept: Any = generator.random(count) >= sensor.lost
    limited = np.clip(rate, -sensor.range_rad_s, sensor.range_rad_s)
    return Measured((time_s + jitter)[kept], limited[kept], acceleration[kept])

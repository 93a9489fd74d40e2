"""What a motion sensor measures: samples in an array, as they are sent, kept and analysed."""

from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.floating[Any]]
Samples = npt.NDArray[np.void]

SAMPLE = np.dtype(
    [
        ("at", "<i8"),
        ("host", "<i8"),
        ("device_ms", "<f8"),
        ("acceleration", "<f4", (3,)),
        ("rate", "<f4", (3,)),
        ("field", "<f4", (3,)),
    ]
)
"""One sample, 60 bytes, little-endian.

``at``: when it was measured, in ns of the session's clock (the device's clock mapped to it). ``host``: when it came
to this computer, same clock. ``device_ms``: the sensor's own clock, ms. ``acceleration``: m/s². ``rate``: angular
rate, rad/s. ``field``: magnetic field, gauss. What a sensor does not measure is NaN.
"""


class Recording(msgspec.Struct, frozen=True):
    """A stretch of samples, ready to be analysed.

    Args:
        time_s: shape (n,), strictly rising, in s.
        rate: angular rate, shape (n, 3), rad/s; x, y, z of the sensor, z out of the back of the hand.
        acceleration: shape (n, 3), m/s²; None where there is none.
        flags: what is known to be wrong with it: ``gap``, ``saturated``, …
    """

    time_s: Floats
    rate: Floats
    acceleration: Floats | None = None
    flags: tuple[str, ...] = ()

    @property
    def rate_hz(self) -> float:
        """Samples a second, from the median step; 0 for fewer than two samples."""
        return 1.0 / float(np.median(np.diff(self.time_s))) if len(self.time_s) > 1 else 0.0


def pack(samples: Samples) -> bytes:
    """Samples as bytes, for a message or the database."""
    return samples.astype(SAMPLE, copy=False).tobytes()


def unpack(data: bytes) -> Samples:
    """The inverse of ``pack``. Raises ValueError for bytes that are no whole samples."""
    return np.frombuffer(data, dtype=SAMPLE)


def recording(samples: Samples, origin_ns: int = 0, flags: tuple[str, ...] = ()) -> Recording:
    """Samples as a recording, its time in s since ``origin_ns``."""
    acceleration = samples["acceleration"].astype(float)
    return Recording(
        time_s=(samples["at"] - origin_ns) / 1e9,
        rate=samples["rate"].astype(float),
        acceleration=None if np.isnan(acceleration).all() else acceleration,
        flags=flags,
    )

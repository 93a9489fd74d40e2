"""Samples of a motion sensor as an array, in the form in which they are sent, stored and
analysed.
"""

from collections.abc import Iterable
from functools import cached_property
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

``at``: time of measurement, in ns of the session's clock (the device's clock mapped to it).
``host``: time of arrival, same clock. ``device_ms``: the sensor's own clock, ms. ``acceleration``:
m/s². ``rate``: angular rate, rad/s. ``field``: magnetic field, gauss. Quantities that a sensor does
not measure are NaN.
"""


class Recording(msgspec.Struct, frozen=True, dict=True):
    """A stretch of samples for analysis.

    Args:
        time_s: shape (n,), strictly increasing, in s.
        rate: angular rate, shape (n, 3), rad/s; x, y, z of the sensor, z out of the back of the
            hand.
        acceleration: shape (n, 3), m/s²; None if not measured.
        flags: known faults: ``gap``, ``saturated``, …
    """

    time_s: Floats
    rate: Floats
    acceleration: Floats | None = None
    flags: tuple[str, ...] = ()

    @cached_property
    def rate_hz(self) -> float:
        """Samples per second, from the median step; 0 for fewer than two samples."""
        if len(self.time_s) < 2:
            return 0.0
        steps = self.time_s[1:] - self.time_s[:-1]
        above, below = len(steps) // 2, (len(steps) - 1) // 2
        middle = np.partition(steps, (below, above))
        return 2.0 / float(middle[below] + middle[above])


def pack(samples: Samples) -> bytes:
    """Return samples as bytes, for a message or the database."""
    return samples.astype(SAMPLE, copy=False).tobytes()


def unpack(data: bytes) -> Samples:
    """Return samples from bytes of ``pack``. Raises ValueError if they are not whole samples."""
    return np.frombuffer(data, dtype=SAMPLE)


def join(blocks: Iterable[Samples]) -> Samples:
    """Return blocks of samples as one; read-only. ``np.concatenate`` takes a hundred times as long
    for records.
    """
    return unpack(b"".join(block.data for block in blocks))


def recording(samples: Samples, origin_ns: int = 0, flags: tuple[str, ...] = ()) -> Recording:
    """Return samples as a recording, with times in s since ``origin_ns``."""
    acceleration = samples["acceleration"].astype(float)
    return Recording(
        time_s=(samples["at"] - origin_ns) / 1e9,
        rate=samples["rate"].astype(float),
        acceleration=None if np.isnan(acceleration).all() else acceleration,
        flags=flags,
    )

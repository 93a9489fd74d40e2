"""Stand-ins for Phidget devices: the library's own ``Spatial`` with callbacks called by hand, and a
servo's limits.
"""

import ctypes
from collections.abc import Sequence
from typing import Any

_Axes = ctypes.c_double * 3

SERVO_LIMITS = {
    "MinPosition": 0.0,
    "MaxPosition": 180.0,
    "MinVelocityLimit": 0.0,
    "MaxVelocityLimit": 6000.0,
    "MinAcceleration": 1.0,
    "MaxAcceleration": 1000.0,
    "MinFailsafeTime": 500,
}
"""Limits of a Phidget RC servo's channel: degrees, degrees/s, degrees/s² and ms."""


class FakeSpatial:
    """A real channel whose queries to the device are answered by constants.

    Args:
        spatial: a ``Phidget22.Devices.Spatial.Spatial``.
        interval_ms: time between two samples.
        model: the device's SKU.
    """

    def __init__(self, spatial: Any, interval_ms: int = 4, model: str = "1044_1B") -> None:
        self.spatial = spatial
        self.interval_ms = interval_ms
        answers: dict[str, Any] = {
            "getDeviceName": "PhidgetSpatial Precision 3/3/3",
            "getDeviceSKU": model,
            "getDeviceSerialNumber": 1,
            "getDeviceVersion": 100,
            "getMinDataInterval": interval_ms,
            "getDataInterval": interval_ms,
            "getMaxAngularRate": [2000.0] * 3,
            "getMaxAcceleration": [8.0] * 3,
            "getMaxMagneticField": [50.0] * 3,
        }
        for name, answer in answers.items():
            setattr(spatial, name, lambda answer=answer: answer)
        spatial.setDataInterval = lambda _: None

    def attach(self) -> None:
        """Plug the device in."""
        self.spatial._onAttach(None, None)

    def detach(self) -> None:
        """Unplug the device."""
        self.spatial._onDetach(None, None)

    def send(
        self,
        index: int,
        rate_deg_s: Sequence[float] = (0.0, 0.0, 0.0),
        acceleration_g: Sequence[float] = (0.0, 0.0, 1.0),
        field_gauss: Sequence[float] = (0.1, 0.2, 0.3),
    ) -> None:
        """Send the sample with this number since the device was attached."""
        axes = (_Axes(*values) for values in (acceleration_g, rate_deg_s, field_gauss))
        self.spatial._onSpatialData(None, None, *axes, float(index * self.interval_ms))

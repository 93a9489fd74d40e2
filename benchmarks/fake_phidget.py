"""Phidget22's own ``Spatial`` with no device behind it: its callbacks are called by hand, as the driver would."""

import ctypes
from collections.abc import Sequence
from typing import Any

_Axes = ctypes.c_double * 3
SATURATED = 4105
"""Phidget22's code for a sample that was left out because an axis was beyond its range."""


class FakeSpatial:
    """A real channel, but for what it would have to ask a device.

    Args:
        spatial: a ``Phidget22.Devices.Spatial.Spatial``; its questions to the device are answered from here on.
        interval_ms: between two samples.
        model: its SKU.
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
        """The device is plugged in."""
        self.spatial._onAttach(None, None)

    def detach(self) -> None:
        """It is pulled out."""
        self.spatial._onDetach(None, None)

    def send(
        self,
        index: int,
        rate_deg_s: Sequence[float] = (0.0, 0.0, 0.0),
        acceleration_g: Sequence[float] = (0.0, 0.0, 1.0),
        field_gauss: Sequence[float] = (0.1, 0.2, 0.3),
    ) -> None:
        """It measured the sample of this number since it was plugged in."""
        axes = (_Axes(*values) for values in (acceleration_g, rate_deg_s, field_gauss))
        self.spatial._onSpatialData(None, None, *axes, float(index * self.interval_ms))

    def saturate(self) -> None:
        """A sample was beyond its range, and is left out."""
        self.spatial._onError(None, None, SATURATED, b"Gyroscope Saturation Detected.")

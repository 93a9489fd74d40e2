"""The PhidgetSpatial: on a USB port of this computer, or on another computer in the network."""

import math
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any, Literal, NamedTuple
from urllib.parse import urlsplit

from sar_tui.drivers.installation import pip_install
from sar_tui.drivers.phidget import UDEV_RULE, describe, new_channel, usb_denied
from sar_tui.inputs.imu import DEGREE, G, Info, Sample, SourceError, Status, Vector
from sar_tui.loop.clock import host_now
from sar_tui.model.language import Sentence

NO_GYROSCOPE = ("1041", "1043", "1049")
"""Models with an accelerometer only."""
SERVER_PORT = 5661
"""Default port of a Phidget network server."""

NO_PACKAGE = "The Python package Phidget22 is missing; install it with: " + pip_install("phidget22")
NO_LIBRARY = (
    "The sensor's driver cannot be loaded ({}); install it with: "
    f"{pip_install('phidget22', 'libusb-package')}"
)
NO_PERMISSION = (
    "A sensor is plugged in, but this computer does not let you use it: write the line "
    f"{UDEV_RULE} into the file /etc/udev/rules.d/70-phidget.rules, unplug the sensor, and plug "
    "it in again."
)

_UNKNOWN = 1e299
"""Phidget22's value for unknown is 1e300."""
_CLOSE_S = 2.0
_LOOK_AGAIN_S = 1.0
_DENIED_CODES = (1, 7)
_DUPLICATE_CODE = 27
_CLEARED, _SATURATED = 4096, 4105
_ADVICE = {
    1: " Install the same version of Phidget22 here and on the network server.",
    2: " Close the other program that uses the sensor.",
    3: " See that the Phidget network server can be reached and asks for no password.",
}


class _Address(NamedTuple):
    serial: int | None = None
    host: str = ""
    port: int = SERVER_PORT

    @property
    def hint(self) -> str:
        """Describe what to do so that a sensor attaches."""
        if self.host:
            return (
                f"Waiting for a PhidgetSpatial of the Phidget network server at {self.host}, "
                f"port {self.port}."
            )
        which = "" if self.serial is None else f" with the serial number {self.serial}"
        return (
            f"Waiting for a PhidgetSpatial{which}: plug it in, and close other programs that "
            "use it."
        )


def _parsed(address: str) -> _Address:
    with suppress(ValueError):
        if not address:
            return _Address()
        if address.isascii() and address.isdigit():
            return _Address(serial=int(address))
        server = urlsplit(address)
        if server.hostname and not server.username and server.scheme in ("", "phidget"):
            return _Address(host=server.hostname, port=server.port or SERVER_PORT)
    raise SourceError(
        Sentence(
            "There is no sensor phidget:{address}. Use phidget, phidget:SERIAL or "
            "phidget://HOST:PORT.",
            address=address,
        )
    )


class PhidgetSource:
    """A PhidgetSpatial 3/3/3 as a source of samples: the 1044_1, and all related models with a
    gyroscope.

    It may be plugged in and out at any time. It is set to its highest sample rate. A Phidget leaves
    out a sample with any axis beyond its range and only reports it: ``saturated``.

    Args:
        address: empty for the first sensor on a USB port; a serial number; ``//HOST:PORT`` for a
            Phidget network server without a password. Raises SourceError for anything else.
        make: makes the channel; Phidget22's ``Spatial`` if None.
        denied: returns True if a sensor is plugged in that this user may not open; looked up if
            None.
    """

    def __init__(
        self,
        address: str = "",
        *,
        make: Callable[[], Any] | None = None,
        denied: Callable[[], bool] | None = None,
    ) -> None:
        self.info: Info | None = None
        self._address = _parsed(address)
        self._make = make or partial(new_channel, "Spatial")
        self._denied = denied or usb_denied
        self._channel: Any = None
        self._stopped = threading.Event()

    def start(self, sink: Callable[[Sample], None], on_status: Callable[[Status], None]) -> None:
        """Wait in the background for a sensor, and deliver its samples."""
        self.stop()
        self._sink, self._on_status = sink, on_status
        self._last_error = ""
        self._stopped = threading.Event()
        self._report_status("detached", self._address.hint)
        try:
            self._open()
        except ImportError:
            self._report_status("error", NO_PACKAGE)
        except OSError as error:
            self._report_status("error", NO_LIBRARY.format(error))
        except Exception as error:
            denied = getattr(error, "code", None) in _DENIED_CODES
            self._report_status(
                "error",
                NO_PERMISSION if denied else f"The sensor cannot be opened: {describe(error)}",
            )
        else:
            if not self._address.host:
                threading.Thread(
                    target=self._watch, args=(self._stopped,), name="phidget", daemon=True
                ).start()

    def stop(self) -> None:
        """Release the sensor. Takes at most two seconds if the driver hangs."""
        self._stopped.set()
        if closing := self._close():
            closing.join(_CLOSE_S)

    def zero(self) -> None:
        """Have the sensor measure its bias, which takes one to two seconds; it must lie still."""
        if self.info is not None and self._channel is not None:
            self._guarded(self._channel.zeroGyro)()

    def _open(self) -> None:
        channel = self._make()
        channel.setOnAttachHandler(self._guarded(self._attached))
        channel.setOnDetachHandler(self._guarded(self._detached))
        channel.setOnErrorHandler(self._guarded(self._erred))
        channel.setOnSpatialDataHandler(self._guarded(self._measured))
        channel.setIsRemote(bool(self._address.host))
        channel.setIsLocal(not self._address.host)
        if self._address.serial is not None:
            channel.setDeviceSerialNumber(self._address.serial)
        if self._address.host:
            self._add_server()
        self._channel = channel
        channel.open()

    def _close(self) -> threading.Thread | None:
        """Close the channel on another thread: the driver may wait for its handlers, and this may
        be one of them.
        """
        channel, self._channel, self.info = self._channel, None, None
        if channel is None:
            return None
        closing = threading.Thread(
            target=self._closed, args=(channel,), name="phidget close", daemon=True
        )
        closing.start()
        return closing

    def _closed(self, channel: Any) -> None:
        for forget in (
            channel.setOnSpatialDataHandler,
            channel.setOnAttachHandler,
            channel.setOnDetachHandler,
            channel.setOnErrorHandler,
        ):
            forget(None)
        with suppress(Exception):
            channel.close()
        if self._address.host:
            with suppress(Exception):
                from Phidget22.Net import Net

                Net.removeServer(self._server)

    @property
    def _server(self) -> str:
        return f"sar-tui {self._address.host}:{self._address.port}"

    def _add_server(self) -> None:
        from Phidget22.Net import Net

        try:
            Net.addServer(self._server, self._address.host, self._address.port, "", 0)
        except Exception as error:
            if getattr(error, "code", None) != _DUPLICATE_CODE:
                raise

    def _attached(self, channel: Any) -> None:
        model = f"{channel.getDeviceName()} ({channel.getDeviceSKU()})"
        if channel.getDeviceSKU().startswith(NO_GYROSCOPE):
            self._report_status(
                "error",
                f"The {model} has no gyroscope, so it cannot measure how a hand turns. "
                "Use a PhidgetSpatial 3/3/3, such as the 1044_1, and start anew.",
            )
            self._close()
            return
        channel.setDataInterval(channel.getMinDataInterval())
        self.info = Info(
            source=self._address.host or "USB",
            model=model,
            serial=str(channel.getDeviceSerialNumber()),
            rate_hz=1000 / channel.getDataInterval(),
            rate_range_rad_s=_limit(channel.getMaxAngularRate) * DEGREE,
            acceleration_range_m_s2=_limit(channel.getMaxAcceleration) * G,
            has_field=_limit(channel.getMaxMagneticField) > 0,
        )
        self._last_error = ""
        self._report_status("attached", f"Firmware {channel.getDeviceVersion()}.")

    def _detached(self, _channel: Any) -> None:
        self.info = None
        self._report_status("detached", self._address.hint)

    def _erred(self, _channel: Any, code: int, description: str) -> None:
        if code == _SATURATED:
            self._report_status("saturated", description, count=1)
        elif code != _CLEARED:
            what = f"The sensor reports: {description.rstrip('.')}.{_ADVICE.get(code, '')}"
            if what != self._last_error:
                self._last_error = what
                self._report_status("error", what)

    def _measured(
        self, _channel: Any, acceleration: Any, rate: Any, field: Any, timestamp: float
    ) -> None:
        self._sink(
            Sample(host_now(), timestamp, _in(G, acceleration), _in(DEGREE, rate), _in(1.0, field))
        )

    def _guarded(self, handle: Callable[..., None]) -> Callable[..., None]:
        """Return a handler whose exceptions become a status, once: the driver would only print
        them.
        """

        def handler(*arguments: Any) -> None:
            try:
                handle(*arguments)
            except Exception as error:
                what = f"The sensor cannot be used: {describe(error)}"
                if what != self._last_error:
                    self._last_error = what
                    self._report_status("error", what)

        return handler

    def _report_status(
        self,
        state: Literal["attached", "detached", "error", "saturated"],
        detail: str = "",
        count: int = 0,
    ) -> None:
        self._on_status(Status(state=state, at=host_now(), detail=detail, count=count))

    def _watch(self, stopped: threading.Event) -> None:
        """Report a sensor that this user may not open; the driver does not report it.

        Checked twice in a row, since the system takes a moment to grant access to a sensor just
        plugged in.
        """
        seen = 0
        while seen < 2 and not stopped.wait(_LOOK_AGAIN_S):
            seen = seen + 1 if self.info is None and self._denied() else 0
        if seen == 2:
            self._report_status("error", NO_PERMISSION)


def _in(unit: float, values: Any) -> Vector:
    x, y, z = values
    return (
        x * unit if abs(x) < _UNKNOWN else math.nan,
        y * unit if abs(y) < _UNKNOWN else math.nan,
        z * unit if abs(z) < _UNKNOWN else math.nan,
    )


def _limit(ask: Callable[[], Any]) -> float:
    """Return the smallest limit of the three axes; 0 if the sensor does not report it."""
    with suppress(Exception):
        limit = float(min(ask()))
        return limit if 0 < limit < _UNKNOWN else 0.0
    return 0.0

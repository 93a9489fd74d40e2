"""Stands in for the library bleak: a Movella DOT whose payloads are made from its maker's
specification. The x axis of the gyroscope numbers the samples.
"""

import asyncio
import struct
from collections.abc import Callable
from typing import Any, Self

_CONTROL = "15172001-4947-11e9-8646-d663bd873d93"
_MEDIUM_PAYLOAD = "15172003-4947-11e9-8646-d663bd873d93"
_START_RATE_QUANTITIES = b"\x01\x01\x15"
_STEP_US = 16667
_BEGAN_US = 2**32 - 500_000
_AFTER_X = bytes.fromhex("0000b4c2 0000003e 00000000 00000000 00000000")
"""Angular velocity y: -90, and z: 0.125; and the unused bytes of 40."""
_ACCELERATION = bytes.fromhex("00000000 00000000 0ae81c41")  # z: 9.80665
_X = bytes.fromhex("00000000 0000803f 00000040 00004040 00008040 0000a040 0000c040")
"""Angular velocity x: 0 to 6."""


class BleakScanner:
    @staticmethod
    async def find_device_by_name(name: str, timeout: float = 10.0) -> str | None:
        return name if name == "Movella DOT" else None


class BleakClient:
    def __init__(self, device: str | None) -> None:
        assert device
        self._callbacks: dict[str, Callable[[Any, bytearray], None]] = {}

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        pass

    async def start_notify(self, characteristic: str, callback: Callable[..., None]) -> None:
        self._callbacks[characteristic] = callback

    async def write_gatt_char(
        self, characteristic: str, data: bytes, response: bool | None = None
    ) -> None:
        assert (characteristic, data) == (_CONTROL, _START_RATE_QUANTITIES)
        self._measuring = asyncio.create_task(self._measure(self._callbacks[_MEDIUM_PAYLOAD]))

    async def _measure(self, notify: Callable[[Any, bytearray], None]) -> None:
        number = 0
        while True:
            number += 1
            x = 4 * (number % 7)
            stamp = struct.pack("<I", (_BEGAN_US + number * _STEP_US) % 2**32)
            notify(None, bytearray(stamp + _ACCELERATION + _X[x : x + 4] + _AFTER_X))
            await asyncio.sleep(0.002)

"""sar-tui without loudspeaker and servo: it plays to a null device, and a fake servo records its commands.

Run ``python -m benchmarks.silent_app FOLDER COMMAND…``. The records of player and servo are files in the folder.
"""

import sys
from functools import partial
from pathlib import Path
from typing import Any

from sar_tui.cli import main as program
from sar_tui.framework.clock import host_now
from sar_tui.outputs.servo import servo
from sar_tui.outputs.sound import mixer

PLAYER, MOTOR = "player.txt", "motor.txt"
_FACTS = {
    "MinPosition": 0.0,
    "MaxPosition": 180.0,
    "MinVelocityLimit": 0.0,
    "MaxVelocityLimit": 6000.0,
    "MinAcceleration": 1.0,
    "MaxAcceleration": 1000.0,
    "MinFailsafeTime": 500,
    "DeviceName": "RC Servo Phidget",
    "DeviceSKU": "RCC1000_0",
    "DeviceSerialNumber": 1,
}


class StandIn:
    """An RC servo's channel that is attached once it is opened. A line a release of the motor: when (ns)."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._attached: Any = None
        self._engaged = False

    def setOnAttachHandler(self, handler: Any) -> None:  # noqa: N802  Phidget22's name
        self._attached = handler

    def open(self) -> None:
        self._attached(self)

    def setEngaged(self, engaged: bool) -> None:  # noqa: N802
        if self._engaged and not engaged:
            with self._file.open("a") as file:
                file.write(f"{host_now()}\n")
        self._engaged = engaged

    def getEngaged(self) -> bool:  # noqa: N802
        return self._engaged

    def __getattr__(self, name: str) -> Any:
        return lambda *_: _FACTS.get(name.removeprefix("get"))


def main() -> None:
    """Put the stand-ins where the program looks for the real ones, and run it."""
    folder = Path(sys.argv.pop(1))
    voice = (sys.executable, "-m", "benchmarks.recorded_player", str(folder / PLAYER))
    mixer.Sound = partial(mixer.Sound, backends=("NULL",), program=voice)  # type: ignore[misc, assignment]
    servo.Servo = partial(  # type: ignore[misc, assignment]
        servo.Servo, make=lambda: StandIn(folder / MOTOR), denied=lambda: False
    )
    program()


if __name__ == "__main__":
    main()

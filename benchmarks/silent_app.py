"""sar-tui with a null audio device and a fake servo, which record when they stop.

Run ``python -m benchmarks.silent_app FOLDER COMMAND…``. The records are files in the folder.
"""

import sys
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.fake_phidget import SERVO_LIMITS
from sar_tui.cli import main as program
from sar_tui.loop.clock import host_now
from sar_tui.outputs.servo import servo
from sar_tui.outputs.sound import mixer

PLAYER, MOTOR = "player.txt", "motor.txt"
_FACTS = {
    **SERVO_LIMITS,
    "DeviceName": "RC Servo Phidget",
    "DeviceSKU": "RCC1000_0",
    "DeviceSerialNumber": 1,
}


class FakeServoChannel:
    """Fake channel of an RC servo, attached when it is opened. Writes the time (ns) of each release
    of the motor.
    """

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
    """Replace the player and the servo channel by the fakes, and run the program."""
    folder = Path(sys.argv.pop(1))
    voice = (sys.executable, "-m", "benchmarks.recorded_player", str(folder / PLAYER))
    mixer.Sound = partial(mixer.Sound, backends=("NULL",), program=voice)  # type: ignore[misc, assignment]
    servo.Servo = partial(  # type: ignore[misc, assignment]
        servo.Servo, make=lambda: FakeServoChannel(folder / MOTOR), denied=lambda: False
    )
    program()


if __name__ == "__main__":
    main()

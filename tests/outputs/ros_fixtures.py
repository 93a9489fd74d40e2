"""A robot behind a local rosbridge server: `ros_rig`, `robot_bench`."""

import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from sar_tui.loop.clock import VirtualClock
from sar_tui.outputs.ros import SETTLE, Ros
from tests.fake_rosbridge import Manner, RosBridge, ros_bridge
from tests.outputs.contract import WAIT_S, Rig


class BenchClock(VirtualClock):
    """A virtual clock to which other threads may hand callbacks: they run when the test's thread
    gets to them.
    """

    def __init__(self) -> None:
        super().__init__()
        self._handed: deque[Callable[[], object]] = deque()

    def call_soon(self, callback: Callable[[], object]) -> None:
        self._handed.append(callback)

    def run_handed(self) -> None:
        while self._handed:
            self._handed.popleft()()


class RosRig(Rig):
    """Rig of a robot, which runs in real time, while the output's clock is virtual."""

    clock: BenchClock

    def wait(self, until: Callable[[], bool]) -> None:
        """Wait for the robot."""
        deadline = time.monotonic() + WAIT_S
        self.clock.run_handed()
        while not until():
            assert time.monotonic() < deadline, f"waited in vain; reported: {self.reports}"
            time.sleep(0.002)
            self.clock.run_handed()


@contextmanager
def robot_bench(
    manner: Manner = "obliging", lasts_s: float = 0.05, options: str = ""
) -> Iterator[tuple[RosRig, RosBridge]]:
    """Provide a robot that is connected and ready."""
    with ros_bridge(manner, lasts_s) as robot:
        rig = RosRig(Ros(f"//{robot.host}{options}"), BenchClock(), ("say", "gesture", "gaze"))
        try:
            rig.wait(lambda: robot.has_subscriber("/sar_tui/report"))
            rig.wait(lambda: is_ready(rig))
            yield rig, robot
        finally:
            rig.output.close()


def is_ready(rig: RosRig) -> bool:
    """Wait until messages are sent after a connection was made."""
    before = rig.clock.now()
    rig.clock.step(before + SETTLE)
    return rig.clock.now() > before


@contextmanager
def ros_rig() -> Iterator[Rig]:
    """Provide a robot that does whatever is requested, for the contract."""
    with robot_bench() as (rig, _):
        yield rig

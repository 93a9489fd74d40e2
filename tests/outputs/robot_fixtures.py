"""Robots behind local servers, each with an output that is connected to it: `ros4hri_bench`,
`furhat_bench`, `reachy_bench`.
"""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any

from sar_tui.model.messages import ActionPart
from sar_tui.outputs.furhat import Furhat
from sar_tui.outputs.reachy import Reachy
from sar_tui.outputs.robot import Robot
from sar_tui.outputs.ros4hri import Ros4Hri
from tests.fake_furhat import FakeFurhat
from tests.fake_reachy import FakeReachy
from tests.fake_rosbridge import RosBridge
from tests.outputs.contract import Rig
from tests.outputs.ros_fixtures import BenchClock, RosRig


@contextmanager
def connected(
    server: Any, make: Callable[[str], Robot], *lasting: ActionPart
) -> Iterator[tuple[RosRig, Any]]:
    """Provide a robot that is connected and ready, and its server."""
    server.arrive()
    rig = RosRig(make(f"//{server.host}"), BenchClock(), lasting)
    try:
        rig.wait(lambda: is_ready(rig))
        yield rig, server
    finally:
        rig.output.close()
        server.close()


def is_ready(rig: RosRig) -> bool:
    """Return True if the output knows that the robot is connected, and what it can do."""
    output: Any = rig.output
    if output._ready_at is None or (isinstance(output, Ros4Hri) and not output._link._servers):
        return False
    rig.clock.advance(max(0, output._ready_at - rig.clock.now()))
    return True


def ros4hri_bench(
    manner: Any = "obliging", lasts_s: float = 0.05, options: str = "", **how: Any
) -> AbstractContextManager[tuple[RosRig, RosBridge]]:
    return connected(
        RosBridge(manner, lasts_s, **how),
        lambda address: Ros4Hri(address + options),
        *("say", "gesture", "gaze"),
    )


def furhat_bench(
    manner: Any = "obliging", lasts_s: float = 0.05, options: str = "", key: str = ""
) -> AbstractContextManager[tuple[RosRig, FakeFurhat]]:
    return connected(
        FakeFurhat(manner, lasts_s, key),
        lambda address: Furhat(f"{address}?wave=Wink{options}"),
        *("say", "gesture"),
    )


def reachy_bench(
    manner: Any = "obliging", pace: float = 1.0
) -> AbstractContextManager[tuple[RosRig, FakeReachy]]:
    return connected(FakeReachy(manner, pace), Reachy, "gesture", "gaze", "say")


@contextmanager
def only_rig(bench: AbstractContextManager[tuple[RosRig, Any]]) -> Iterator[Rig]:
    """Provide the output of a bench, for the contract."""
    with bench as (rig, _):
        yield rig

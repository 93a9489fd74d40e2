"""For a motion sensor: the contract of a source, and a feed to try one without a session.

The feed needs numpy, and is loaded when it is first used.
"""

from typing import TYPE_CHECKING

from sar_tui.api._names import names_on_demand
from sar_tui.inputs.imu import NOTHING, ImuSource, Info, Sample, SourceError, Status, Vector
from sar_tui.loop.clock import host_now
from sar_tui.model.units import MS, SECOND

if TYPE_CHECKING:
    from sar_tui.inputs.imu_feed import Drained, ImuFeed
    from sar_tui.inputs.sources import open_source

# fmt: off
__all__ = [  # noqa: RUF022  in groups
    # the contract
    "ImuSource", "Info", "Sample", "Status", "SourceError",
    # values of a sample
    "Vector", "NOTHING", "host_now", "MS", "SECOND",
    # to try a sensor
    "open_source", "ImuFeed", "Drained",
]
# fmt: on

_LOADED_LATER = {
    "sar_tui.inputs.imu_feed": "Drained ImuFeed",
    "sar_tui.inputs.sources": "open_source",
}
RETIRED: dict[str, str] = {}

if not TYPE_CHECKING:
    __getattr__ = names_on_demand(__name__, _LOADED_LATER, RETIRED)

"""For the tests of a plug-in: tasks and themes by name, and the checks of contracts."""

from typing import TYPE_CHECKING

from sar_tui.api._names import names_on_demand
from sar_tui.plugins import Catalogue, PluginError, load_task, load_theme

if TYPE_CHECKING:
    from sar_tui.checks.sensor import SensorBench, check_sensor
    from sar_tui.checks.task import check

__all__ = [
    "Catalogue", "PluginError", "SensorBench", "check", "check_sensor", "load_task", "load_theme",
]  # fmt: skip

_LOADED_LATER = {
    "sar_tui.checks.sensor": "SensorBench check_sensor",
    "sar_tui.checks.task": "check",
}
RETIRED: dict[str, str] = {}

if not TYPE_CHECKING:
    __getattr__ = names_on_demand(__name__, _LOADED_LATER, RETIRED)

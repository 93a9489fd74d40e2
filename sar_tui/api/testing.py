"""For the tests of a plug-in: tasks and themes by name, and the checks of their contracts."""

from typing import TYPE_CHECKING

from sar_tui.api._names import names_on_demand
from sar_tui.plugins import Catalogue, PluginError, load_task, load_theme

if TYPE_CHECKING:
    from sar_tui.checks.task import check

__all__ = ["Catalogue", "PluginError", "check", "load_task", "load_theme"]

_LOADED_LATER = {"sar_tui.checks.task": "check"}
RETIRED: dict[str, str] = {}

if not TYPE_CHECKING:
    __getattr__ = names_on_demand(__name__, _LOADED_LATER, RETIRED)

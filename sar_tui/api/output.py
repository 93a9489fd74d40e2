"""For an output: a medium through which the agent reaches the participant."""

from typing import TYPE_CHECKING

from sar_tui.api._names import names_on_demand
from sar_tui.loop.clock import Clock
from sar_tui.model.gesture import Gesture
from sar_tui.model.messages import ActionPart, PartState
from sar_tui.model.theme import FACES, Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs.output import Gaze, Output, OutputError, Report

# fmt: off
__all__ = [  # noqa: RUF022  in groups
    # the contract
    "Output", "OutputError", "Report", "ActionPart", "PartState",
    # what it is given
    "Theme", "Gesture", "FACES", "Gaze", "Clock",
    # units of time
    "MS", "SECOND",
]
# fmt: on

RETIRED: dict[str, str] = {}

if not TYPE_CHECKING:
    __getattr__ = names_on_demand(__name__, {}, RETIRED)

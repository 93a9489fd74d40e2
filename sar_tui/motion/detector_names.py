"""Names of the detectors, in a module that loads without numpy."""

from typing import Literal

DetectorName = Literal["orientation", "single-axis", "fixed-threshold"]

COLUMN_NAMES: dict[DetectorName, str] = {
    "orientation": "orientation",
    "single-axis": "single_axis",
    "fixed-threshold": "fixed_threshold",
}
"""Each detector's name in the names of columns."""

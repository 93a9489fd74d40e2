"""Names of the detectors, in a module that loads without numpy."""

from typing import Literal

DetectorName = Literal["orientation", "single-axis", "fixed-threshold"]

STORED_NAMES: dict[DetectorName, str] = {
    "orientation": "orientation",
    "single-axis": "robust",
    "fixed-threshold": "thesis",
}
"""Each detector's name in stored trials and in the names of columns: the first that it had."""

RENAMED: dict[str, DetectorName] = {stored: name for name, stored in STORED_NAMES.items()}
"""The present name for each earlier one. Earlier names are still accepted."""


def current_name(name: str) -> str:
    """Return the present name of a detector, given that or an earlier one."""
    return RENAMED.get(name, name)

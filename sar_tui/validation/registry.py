"""The validations by name."""

from collections.abc import Callable
from typing import NamedTuple

from sar_tui.validation import modularity, reach, table_4_1
from sar_tui.validation.report import Conditions, Report


class Validation(NamedTuple):
    """A title, and what does it."""

    title: str
    run: Callable[[Conditions], Report]


VALIDATIONS: dict[str, Validation] = {
    "table-4.1": Validation("The thesis' Table 4.1: eight simulated reaches, measured", table_4_1.run),
    "reach": Validation("Reaches under difficulties, by both detectors", reach.run),
    "modularity": Validation("How much of the code that a session runs is the framework's", modularity.run),
}

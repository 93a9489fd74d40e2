"""The validations by name."""

from collections.abc import Callable
from typing import NamedTuple

from sar_tui.validation import (
    adaptation,
    difficulty,
    effects,
    feedback,
    modularity,
    reach,
    requirements,
    table_4_1,
)
from sar_tui.validation.report import Conditions, Report


class Validation(NamedTuple):
    """A title and the function that runs it.

    ``seconds``: what it takes in the quick form, about; the time left is told by it.
    """

    title: str
    run: Callable[[Conditions], Report]
    seconds: float = 1.0


VALIDATIONS: dict[str, Validation] = {
    "figure-4.4": Validation(
        "The thesis' Figure 4.4: the level for an average user over twenty attempts",
        adaptation.average,
    ),
    "figure-4.8": Validation(
        "The thesis' Figure 4.8: angular velocity in eight simulated reaches",
        table_4_1.simulated_velocity,
        0.1,
    ),
    "figure-4.9": Validation(
        "The thesis' Figure 4.9: the level for a poor user over twenty attempts", adaptation.poor
    ),
    "figure-4.10": Validation(
        "The thesis' Figure 4.10: the level for a competent user", adaptation.competent
    ),
    "figure-4.11": Validation(
        "The thesis' Figure 4.11: feedback for a poor user over twenty attempts", feedback.poor, 0.1
    ),
    "figure-4.12": Validation(
        "The thesis' Figure 4.12: feedback for a competent user", feedback.competent, 0.1
    ),
    "figure-4.13": Validation(
        "The thesis' Figure 4.13: what is said, in words and in figures", feedback.examples
    ),
    "figure-4.14": Validation(
        "The thesis' Figure 4.14: feedback every attempt, and every three", feedback.frequency
    ),
    "figure-4.15": Validation(
        "The thesis' Figure 4.15: what the reaching task adds to the loop",
        modularity.added_parts,
        0.1,
    ),
    "table-4.1": Validation(
        "The thesis' Table 4.1: eight simulated reaches, measured", table_4_1.run, 0.1
    ),
    "table-4.2": Validation("The thesis' Table 4.2: the four requirements", requirements.run, 3),
    "reach": Validation(
        "Reaches under difficulties, and of ten kinds about many axes, by each detector",
        reach.run,
        1.5,
    ),
    "difficulty": Validation(
        "Success and fitting challenge under each difficulty policy", difficulty.run, 2
    ),
    "effects": Validation(
        "Published effects of the tasks, in simulated participants and in controls", effects.run, 7
    ),
    "modularity": Validation(
        "Share of the framework in the code that a session runs", modularity.run, 8
    ),
}

"""The validations by name."""

from collections.abc import Callable
from typing import NamedTuple

from sar_tui.validation import difficulty, feedback, modularity, policies, progress, reach, table_4_1
from sar_tui.validation.report import Conditions, Report


class Validation(NamedTuple):
    """A title and the function that runs it."""

    title: str
    run: Callable[[Conditions], Report]


VALIDATIONS: dict[str, Validation] = {
    "figure-4.11": Validation("The thesis' Figure 4.11: feedback for a poor user over twenty attempts", feedback.poor),
    "figure-4.12": Validation("The thesis' Figure 4.12: feedback for a competent user", feedback.competent),
    "figure-4.13": Validation("The thesis' Figure 4.13: what is said, in words and in figures", feedback.examples),
    "figure-4.14": Validation("The thesis' Figure 4.14: feedback every attempt, and every three", feedback.frequency),
    "table-4.1": Validation("The thesis' Table 4.1: eight simulated reaches, measured", table_4_1.run),
    "reach": Validation("Reaches under difficulties, by both detectors", reach.run),
    "policies": Validation("Feedback under each schedule, and the reasons", policies.run),
    "progress": Validation("Progress over sessions: bands and verdicts on simulated histories", progress.run),
    "difficulty": Validation("Success and fitting challenge under each difficulty policy", difficulty.run),
    "modularity": Validation("Share of the framework in the code that a session runs", modularity.run),
}

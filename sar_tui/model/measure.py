"""Declared measures of an attempt: their names for people, units and decimals."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import msgspec

if TYPE_CHECKING:
    from sar_tui.model.language import Language


class Measure(msgspec.Struct, frozen=True):
    """Title, unit and decimals of a number that `Task.measures` or `Task.learning` returns.

    Args:
        name: of the number.
        title: for people: "congruency effect".
        unit: of the number.
        decimals: number of decimals shown.
    """

    name: str
    title: str
    unit: str = ""
    decimals: int = 1

    def label(self, tr: "Language") -> str:
        """Return title and unit, for display: "congruency effect (ms)"."""
        return f"{tr(self.title)} ({tr(self.unit)})" if self.unit else tr(self.title)

    def show(self, value: float, tr: "Language") -> str:
        """Return a value with its unit, for display: "38.2 ms"."""
        return f"{tr.figures(f'{value:.{self.decimals}f}')} {tr(self.unit)}".rstrip()


def mean_texts(
    measured: Iterable[Measure], attempts: Sequence[Mapping[str, float]], tr: "Language"
) -> list[str]:
    """Return a sentence for each declared measure that some attempts have, with its mean:
    "Congruency effect: 38 ms."

    Args:
        measured: declared by the task.
        attempts: the measures of each attempt, by name.
        tr: the reader's language.
    """
    from statistics import fmean

    said = []
    for measure in measured:
        if values := [each[measure.name] for each in attempts if measure.name in each]:
            title = tr(measure.title)
            said.append(f"{title[:1].upper()}{title[1:]}: {measure.show(fmean(values), tr)}.")
    return said

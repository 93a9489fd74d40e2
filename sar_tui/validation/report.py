"""Results of a validation: figures, and claims that hold or do not."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from sar_tui.plugins import Catalogue

Row = dict[str, Any]


class Claim(NamedTuple):
    """A sentence that holds if ``against``, a list of exceptions, is empty."""

    sentence: str
    against: str = ""

    @property
    def holds(self) -> bool:
        return not self.against


class Column(NamedTuple):
    """A column of a printed table: its head, and the text for a row (None for empty)."""

    head: str
    show: Callable[[Row], str | None]
    is_number: bool = True


class Report(NamedTuple):
    """Figures as rows of named values, the printed tables, and the claims about them.

    ``drawings``: text printed before the tables; ``seen``: the rows of the tables, if not all;
    ``chart``: the same drawing in Vega-Lite, for a file.
    """

    rows: Sequence[Row]
    tables: Sequence[Sequence[Column]]
    claims: Sequence[Claim]
    drawings: Sequence[str] = ()
    seen: Sequence[Row] | None = None
    chart: Row | None = None


class Conditions(NamedTuple):
    """Conditions of a validation.

    Args:
        catalogue: the installed tasks.
        reaches: number of reaches for each scenario.
        is_quick: fewer repetitions.
        seeds: those with which a claim about users is tested.
        progress: called with the current step, the number of steps done, and their total.
        known: sessions that were simulated, which validations share; None to simulate each.
    """

    catalogue: "Catalogue"
    reaches: int = 200
    is_quick: bool = False
    seeds: Sequence[int] = range(1, 11)
    progress: Callable[[str, int, int], None] = lambda what, done, of: None
    known: dict[object, Any] | None = None

"""What a validation comes to: figures, and claims that hold or do not."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from sar_tui.plugins import Catalogue

Row = dict[str, Any]


class Claim(NamedTuple):
    """A sentence that holds or not; ``against`` says by what it does not."""

    sentence: str
    against: str = ""

    @property
    def holds(self) -> bool:
        return not self.against


class Column(NamedTuple):
    """A column for people: its head, and what it shows of a row. None is nothing."""

    head: str
    show: Callable[[Row], str | None]
    is_number: bool = True


class Report(NamedTuple):
    """Figures as rows of named values, the tables in which people see them, and the claims about them.

    ``drawings``: what people see before the tables, as text; ``seen``: the rows of the tables, where those are fewer.
    """

    rows: Sequence[Row]
    tables: Sequence[Sequence[Column]]
    claims: Sequence[Claim]
    drawings: Sequence[str] = ()
    seen: Sequence[Row] | None = None


class Conditions(NamedTuple):
    """What a validation is done with.

    Args:
        catalogue: the tasks that are installed.
        reaches: how many reaches each scenario is tried with.
        progress: is told what is under way, how much of it is done, and of how much.
    """

    catalogue: "Catalogue"
    reaches: int = 200
    progress: Callable[[str, int, int], None] = lambda what, done, of: None

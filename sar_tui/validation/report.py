"""Results of a validation: figures, and claims that hold or do not."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Any, NamedTuple

from sar_tui.reports.charts import ChartsMissing
from sar_tui.reports.sections import document, figure, table

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


# --- the page


_LISTED = 60
"""Rows of a table; the files have all."""
_FOOT = (
    "Simulated people obey the model that they are made of: what they show holds for the program, "
    "and for people only as far as they are like the model."
)


def page(title: str, reports: Mapping[str, tuple[str, Report]], notes: Sequence[str] = ()) -> str:
    """Return a self-contained page.

    Args:
        reports: with their titles, by name.
        notes: sentences on what is not there.

    Without the extra ``report``, figures are drawn with characters.
    """
    body = [f"<h1>{escape(title)}</h1>"]
    claims = [claim for _, report in reports.values() for claim in report.claims]
    if claims:
        held = sum(claim.holds for claim in claims)
        body.append(f"<p><strong>{held} of {len(claims)} claims hold.</strong></p>")
    body += [f"<p>{escape(note)}</p>" for note in notes]
    for name, (heading, report) in reports.items():
        body += _section(name, heading, report)
    return document(title, body, foot=_FOOT)


def _section(name: str, heading: str, report: Report) -> Iterator[str]:
    yield f'<h2 id="{escape(name)}">{escape(heading)}</h2>'
    yield from _figure(heading, report)
    for columns in report.tables:
        yield f'<div class="wide">{_table(columns, report)}</div>'
    if report.claims:
        lines = "".join(
            f"<li>{'✓' if claim.holds else '✗'} "
            f"{escape(claim.sentence)}{_against(claim.against)}</li>"
            for claim in report.claims
        )
        yield f'<ul class="claims">{lines}</ul>'


def _figure(heading: str, report: Report) -> Iterator[str]:
    if report.chart is not None:
        try:
            yield figure(report.chart, heading, is_captioned=False)
        except ChartsMissing:
            pass
        else:
            return
    yield from (f'<pre class="drawing">{escape(drawing)}</pre>' for drawing in report.drawings)


def _against(against: str) -> str:
    return f" <strong>But {escape(against)}.</strong>" if against else ""


def _table(columns: Sequence[Column], report: Report) -> str:
    rows = report.rows if report.seen is None else report.seen
    shown = ([column.show(row) or "" for column in columns] for row in rows[:_LISTED])
    return table(
        [column.head for column in columns],
        list(shown),
        right=[c.head for c in columns if c.is_number],
    )

"""Console and tables for people, on standard output."""

from collections.abc import Callable, Iterable, Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from rich import box
from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from sar_tui.cli.common import console, print_json
from sar_tui.cli.visible_output import KEPT
from sar_tui.model.visible_text import visible

if TYPE_CHECKING:
    from sar_tui.model.measure import Measure
    from sar_tui.model.messages import AttemptEnded
    from sar_tui.model.trial_types import Metric

Row = dict[str, Any]
Findings = Callable[[Sequence["AttemptEnded"], "Metric"], Sequence[str]]
"""Sentences that a task's view adds to a summary (`task_view.stored_findings`)."""


_GAP = "   "
_ROWS = 1000
"""Number of rows that are printed at once."""


class VisibleConsole(Console):
    """Console for texts from anywhere. Only what rich itself sends to the terminal are commands."""

    def render_str(self, text: str, **how: Any) -> Text:
        """Return a string as text. Done here, before its length is measured."""
        return super().render_str(visible(text, KEPT), **how)

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterable[Segment]:
        for segment in super().render(renderable, options):
            yield (
                segment if segment.control else Segment(visible(segment.text, KEPT), segment.style)
            )


def table(*columns: str, right: Sequence[str] = (), whole: Sequence[str] = ()) -> Table:
    """Return an empty table. Columns in ``right`` are right-aligned; those in ``whole`` are never
    folded.
    """
    made = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for column in columns:
        justify: Literal["left", "right"] = "right" if column in right else "left"
        made.add_column(column, justify=justify, overflow="fold", no_wrap=column in whole)
    return made


def add(made: Table, *cells: object) -> None:
    """Add a row. Markup is not interpreted; an empty cell is a dash."""
    made.add_row(*(Text("–" if cell in (None, "") else visible(str(cell), "\n")) for cell in cells))


def head(made: Table, heading: str) -> None:
    """Add a heading to a table."""
    made.add_row()
    made.add_row(Text(heading, style="bold"))


def print_table(
    out: Console,
    columns: Sequence[str],
    rows: Sequence[Sequence[object]],
    *,
    right: Sequence[str] = (),
) -> None:
    """Print a table. Columns in ``right`` are right-aligned; an empty cell is a dash; a long line
    is not folded.

    The name of a column may have several lines.
    """
    cells = [["–" if cell in (None, "") else str(cell) for cell in row] for row in rows]
    heads = list(zip_longest(*(column.split("\n") for column in columns), fillvalue=""))
    widths = [max(map(len, column)) for column in zip(*heads, *cells, strict=True)]

    def line(row: Sequence[str]) -> str:
        aligned = (
            cell.rjust(width) if name in right else cell.ljust(width)
            for name, cell, width in zip(columns, row, widths, strict=True)
        )
        return _GAP.join(aligned).rstrip()

    rule = "─" * (sum(widths) + len(_GAP) * (len(columns) - 1))
    lines = [*map(line, heads), rule, *map(line, cells)]
    for first in range(0, len(lines), _ROWS):
        out.print(
            "\n".join(lines[first : first + _ROWS]), markup=False, highlight=False, soft_wrap=True
        )


def attempts_table(
    rows: Sequence[Row], metric: "Metric", measured: Sequence["Measure"] = ()
) -> Table:
    """Return a table of attempts, one row for each seat, with the declared measures that some of
    them have.
    """
    from sar_tui.model.language import ENGLISH
    from sar_tui.reports.charts import MARKERS, result_name

    result = metric.name.replace("_", " ") or "result"
    seat = ("seat",) if len(seats(rows)) > 1 else ()
    tr = ENGLISH
    known = [
        measure for measure in measured if any(measure.name in row["qualities"] for row in rows)
    ]
    titles = [measure.title for measure in known]
    numbers = ("attempt", "level", result, "right", *titles)
    made = table(
        "attempt", *seat, "level", result, "right", *titles, "goal", "feedback", right=numbers
    )
    for row in rows:
        name = result_name(row["outcome"], row["metric"], row["goal"], metric)
        add(
            made,
            f"{row['attempt']}{' practice' if row['practice'] else ''}",
            *(row[name] for name in seat),
            row["level"],
            None if row["metric"] is None else metric.show(row["metric"]),
            f"{row['correct']} of {row['trials']}",
            *(
                each.show(row["qualities"][each.name], tr) if each.name in row["qualities"] else ""
                for each in known
            ),
            "" if name == "no goal" else f"{MARKERS[name]} {name}",
            "" if row["feedback"] == "none" else row["feedback"],
        )
    return made


def seats(rows: Sequence[Row]) -> list[str]:
    """Return the seats, sorted."""
    return sorted({row["seat"] for row in rows})


def summary(rows: Sequence[Row], metric: "Metric", findings: Findings = lambda *_: ()) -> str:
    """Sum up a session in a few sentences, seat by seat where there are several; practice does not
    count.
    """
    from sar_tui.store.sessions import attempt_ended

    if len(taken := seats(rows)) > 1:
        mine = {seat: [row for row in rows if row["seat"] == seat] for seat in taken}
        return " ".join(
            f"Seat {seat}: {summary(own, metric, findings)}" for seat, own in mine.items()
        )
    scored = [row for row in rows if not row["practice"]]
    if not scored:
        return "No attempt was finished."
    reached = sum(row["outcome"] == "success" for row in scored)
    told = (
        "" if all(row["outcome"] == "none" for row in scored) else f"{reached} reached the goal, "
    )
    levels = [row["level"] for row in scored]
    values = [row["metric"] for row in scored if row["metric"] is not None]
    mean = (
        f", mean {metric.name.replace('_', ' ')} {metric.show(sum(values) / len(values))}"
        if values
        else ""
    )
    return " ".join(
        (
            f"{len(scored)} attempt{'s' if len(scored) > 1 else ''}, {told}"
            f"levels {min(levels)} to {max(levels)}{mean}.",
            *findings([attempt_ended(row) for row in scored], metric),
        )
    )


# --- listings


class Column(NamedTuple):
    """A column for people: its heading, and its value for a row (None or empty: a dash)."""

    head: str
    value: Callable[[Any], object]
    is_number: bool = False


class Listing(NamedTuple):
    """Declares a listing.

    Args:
        name: key of the rows in JSON, which has all their fields.
        empty: what people read if there are no rows.
        columns: what people read of each row.
        folds: long cells are folded, except in the columns ``whole``; otherwise lines are long.
    """

    name: str
    empty: str
    columns: Sequence[Column]
    folds: bool = False
    whole: Sequence[str] = ()


def print_listing(listing: Listing, rows: Sequence[Any], as_json: bool, **more: Any) -> None:
    """Print rows, which JSON has as they are.

    Args:
        more: further keys of the JSON.
    """
    if as_json:
        print_json({listing.name: rows, **more})
        return
    out = console()
    if not rows:
        out.print(listing.empty, soft_wrap=True)
        return
    heads = [column.head for column in listing.columns]
    right = [column.head for column in listing.columns if column.is_number]
    cells = [[column.value(row) for column in listing.columns] for row in rows]
    if not listing.folds:
        print_table(out, heads, cells, right=right)
        return
    made = table(*heads, right=right, whole=listing.whole)
    for row in cells:
        add(made, *row)
    out.print(made)

"""Listings: commands that print rows of one kind, as a table or as JSON."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from sar_tui.cli.common import console, print_json


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


def print_listing(listing: Listing, rows: Sequence[Any], as_json: bool) -> None:
    """Print rows, which JSON has as they are."""
    if as_json:
        print_json({listing.name: rows})
        return
    out = console()
    if not rows:
        out.print(listing.empty, soft_wrap=True)
        return
    from sar_tui.cli.tables import add, print_table, table

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

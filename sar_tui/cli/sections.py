"""Prints the sections of a report."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from sar_tui.reports.sections import Section


def print_sections(out: "Console", sections: Iterable["Section"], *, titled: bool = True) -> None:
    """Print sections with an empty line between their parts. ``titled``: with their titles."""
    from rich.text import Text

    from sar_tui.cli.tables import add, table
    from sar_tui.model.visible_text import visible
    from sar_tui.reports.sections import Drawing, Table

    is_first = True
    for section in sections:
        for index, part in enumerate(section.parts):
            if not is_first:
                out.print()
            is_first = False
            if titled and not index:
                out.print(Text(section.title, style="bold"), soft_wrap=True)
            match part:
                case Table():
                    shown = table(*part.heads, right=part.right, whole=part.whole)
                    for row in part.rows:
                        add(shown, *row)
                    out.print(shown)
                    if part.more:
                        out.print(part.more, markup=False, soft_wrap=True)
                case Drawing():
                    out.print("\n".join([part.caption, *part.lines]), markup=False, soft_wrap=True)
                case _:
                    out.print(visible(part, "\n"), markup=False, soft_wrap=True)

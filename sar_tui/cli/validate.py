"""``sar-tui validate``: checks claims of the thesis and of this project by simulation."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import AsJson, Data, Home, Tasks, console, named_path, print_json, progress_bar
from sar_tui.cli.errors import Refused
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    from rich.console import Console

    from sar_tui.validation.report import Report

_PAGE = 120
"""Line length of stored text."""


def validate(
    context: typer.Context,
    only: Annotated[
        str | None,
        typer.Option(
            metavar="NAME,NAME",
            show_default=False,
            help="figure-4.11, figure-4.12, figure-4.13, figure-4.14, table-4.1, reach, policies, difficulty, "
            "progress, modularity; default: all.",
        ),
    ] = None,
    to: Annotated[
        Path | None,
        typer.Option(
            parser=named_path,
            metavar="DIR",
            show_default=False,
            help="Store all rows (NAME.csv) and the printed text (NAME.txt) here.",
        ),
    ] = None,
    reaches: Annotated[
        int, typer.Option(metavar="N", min=1, max=100_000, help="Number of reaches for each difficulty.")
    ] = 200,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Check the claims of the thesis and of this project by simulation.

    Exits with 1 if a claim does not hold.
    """
    from sar_tui.validation.registry import VALIDATIONS
    from sar_tui.validation.report import Conditions

    catalogue = Home.of(context, data, tasks).catalogue()
    names = _names(only, list(VALIDATIONS))
    if to is not None:
        _prepare_folder(to, names)
    reports = {}
    with progress_bar() as bar:
        line = bar.add_task("", total=None)

        def progress(what: str, done: int, of: int) -> None:
            bar.update(line, description=what, completed=done, total=of)

        for name in names:
            reports[name] = VALIDATIONS[name].run(Conditions(catalogue, reaches, progress))
            if to is not None:
                _store(to, name, VALIDATIONS[name].title, reports[name])
    if as_json:
        print_json({name: report.rows for name, report in reports.items()})
    else:
        for name, report in reports.items():
            _print(console(), VALIDATIONS[name].title, report)
    against = [claim for report in reports.values() for claim in report.claims if not claim.holds]
    if against:
        if as_json:
            for claim in against:
                console(error=True).print(_verdict(claim.sentence, claim.against), markup=False, soft_wrap=True)
        raise typer.Exit(FAILED)


def _names(only: str | None, known: Sequence[str]) -> list[str]:
    """Return the requested validations, in their own order. Raises Refused."""
    if only is None:
        return list(known)
    asked = [name.strip() for name in only.split(",") if name.strip()]
    for name in asked:
        if name not in known:
            raise Refused(f"There is no validation {name}. Choose one of: {', '.join(known)}.")
    if not asked:
        raise Refused(f"Name a validation: --only {','.join(known)}.")
    return [name for name in known if name in asked]


def _prepare_folder(folder: Path, names: Sequence[str]) -> None:
    """Make the folder. Raises Refused if it holds one of the files to be written."""
    for file in (f"{name}.{kind}" for name in names for kind in ("csv", "txt")):
        if (folder / file).exists():
            raise Refused(f"{folder} already holds a {file}, which is not overwritten. Name another folder.")
    folder.mkdir(parents=True, exist_ok=True)


def _store(folder: Path, name: str, title: str, report: "Report") -> None:
    """Write a validation's rows and its printed text."""
    import csv

    from rich.console import Console

    with (folder / f"{name}.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(report.rows[0]) if report.rows else [])
        writer.writeheader()
        writer.writerows(report.rows)
    with (folder / f"{name}.txt").open("w", encoding="utf-8") as file:
        _print(Console(file=file, width=_PAGE), title, report)


def _print(out: "Console", title: str, report: "Report") -> None:
    from sar_tui.cli.tables import add, table

    out.print(f"{title}\n", markup=False)
    for drawing in report.drawings:
        out.print(drawing, markup=False, soft_wrap=True)
        out.print()
    for columns in report.tables:
        made = table()
        made.padding = (0, 1, 0, 0)
        for column in columns:
            made.add_column(column.head, justify="right" if column.is_number else "left", overflow="fold")
        for row in report.rows if report.seen is None else report.seen:
            add(made, *(column.show(row) for column in columns))
        out.print(made)
        out.print()
    for claim in report.claims:
        out.print(_verdict(claim.sentence, claim.against), markup=False, soft_wrap=True)
    out.print()


def _verdict(sentence: str, against: str) -> str:
    return f"✗ {sentence} But {against}." if against else f"✓ {sentence}"

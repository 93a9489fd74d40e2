"""``sar-tui validate``: checks claims of the thesis and of this project by simulation."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import AsJson, Home, console, named_path, print_json
from sar_tui.cli.errors import Refused
from sar_tui.cli.progress_line import progress_line
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    from rich.console import Console

    from sar_tui.validation.report import Report

_PAGE = 120
"""Line length of stored text."""
_WHOLE = "validation.html"
_QUICK_SEEDS = 3
_REACHES = {False: 20, True: 200}
"""Reaches for each difficulty, in the quick form and in the full one."""


def validate(
    home: Home,
    only: Annotated[
        str | None,
        typer.Option(
            metavar="NAME,NAME",
            show_default=False,
            help="figure-4.4, figure-4.8, figure-4.9, figure-4.10, figure-4.11, figure-4.12, "
            "figure-4.13, figure-4.14, figure-4.15, table-4.1, table-4.2, reach, "
            "difficulty, effects, modularity; default: all.",
        ),
    ] = None,
    to: Annotated[
        Path | None,
        typer.Option(
            parser=named_path,
            metavar="DIR",
            show_default=False,
            help="Store all rows (NAME.csv), the printed text (NAME.txt), the figures (NAME.svg) "
            "and one page of all "
            "(validation.html) here. Figures need the extra `report`.",
        ),
    ] = None,
    reaches: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=1,
            max=100_000,
            show_default=False,
            help="Number of reaches for each difficulty. Default: 20, and 200 with --full.",
        ),
    ] = None,
    full: Annotated[
        bool,
        typer.Option(
            "--full", help="With all repetitions, as for a paper: up to a quarter of an hour."
        ),
    ] = False,
    session: Annotated[
        str | None,
        typer.Option(
            "--session",
            metavar="SESSION|last",
            show_default=False,
            help="Make the thesis' figures of a recorded session instead.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Check the claims of the thesis and of this project by simulation.

    Exits with 1 if a claim does not hold.
    """
    if session is not None:
        if only is not None or full:
            raise Refused(
                "--session makes the figures that the session has: leave out --only and --full."
            )
        _show_session(home, session, to, as_json)
        return
    from sar_tui.validation.registry import VALIDATIONS
    from sar_tui.validation.report import Conditions

    catalogue = home.catalogue()
    names = _names(only, list(VALIDATIONS))
    if to is not None:
        _prepare_folder(to, names)
    reports = {}
    with progress_line("Validating", piped=True) as show:
        whole, before = sum(VALIDATIONS[name].seconds for name in names), 0.0

        def progress(what: str, done: int, of: int) -> None:
            show(what, before + VALIDATIONS[name].seconds * done / max(1, of), whole)

        given = Conditions(
            catalogue, reaches or _REACHES[full], not full, progress=progress, known={}
        )
        conditions = given if full else given._replace(seeds=given.seeds[:_QUICK_SEEDS])
        for name in names:
            show(name, before, whole)
            reports[name] = VALIDATIONS[name].run(conditions)
            before += VALIDATIONS[name].seconds
            if to is not None:
                _store(to, name, VALIDATIONS[name].title, reports[name])
    titled = {name: (VALIDATIONS[name].title, report) for name, report in reports.items()}
    if to is not None:
        _store_page(to, "Validation", titled)
    if as_json:
        print_json({name: report.rows for name, report in reports.items()})
    else:
        for title, report in titled.values():
            _print(console(), title, report)
    against = [claim for report in reports.values() for claim in report.claims if not claim.holds]
    if against:
        if as_json:
            for claim in against:
                console(error=True).print(
                    _verdict(claim.sentence, claim.against), markup=False, soft_wrap=True
                )
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
    for file in (_WHOLE, *(f"{name}.{kind}" for name in names for kind in ("csv", "txt", "svg"))):
        if (folder / file).exists():
            raise Refused(
                f"{folder} already holds a {file}, which is not overwritten. Name another folder."
            )
    folder.mkdir(parents=True, exist_ok=True)


def _store(folder: Path, name: str, title: str, report: "Report") -> None:
    """Write a validation's rows and its printed text."""
    from rich.console import Console

    from sar_tui.export.csv_file import CsvWriter

    with (folder / f"{name}.csv").open("w", encoding="utf-8", newline="") as file:
        writer = CsvWriter(file)
        heads = list(report.rows[0]) if report.rows else []
        writer.row(heads)
        writer.rows([row[head] for head in heads] for row in report.rows)
    with (folder / f"{name}.txt").open("w", encoding="utf-8") as file:
        _print(Console(file=file, width=_PAGE), title, report)
    if report.chart is not None:
        from sar_tui.reports.charts import ChartsMissing, drawn

        with suppress(ChartsMissing):  # said once, with the page
            (folder / f"{name}.svg").write_text(drawn(report.chart), encoding="utf-8")


def _store_page(
    folder: Path, title: str, reports: "Mapping[str, tuple[str, Report]]", notes: Sequence[str] = ()
) -> None:
    """Write one page of all reports."""
    from sar_tui.drivers.files import write_private
    from sar_tui.validation.report import page

    write_private(folder / _WHOLE, page(title, reports, notes))
    lacking = any(
        report.chart and not (folder / f"{name}.svg").exists()
        for name, (_, report) in reports.items()
    )
    if lacking:
        from sar_tui.reports.charts import no_package

        console(error=True).print(
            f"! {no_package()}. Everything but NAME.svg is written.", soft_wrap=True
        )


def _show_session(home: Home, name: str, to: Path | None, as_json: bool) -> None:
    """Make the thesis' figures of a recorded session."""
    from sar_tui.validation.recorded_session import TITLES, reports

    with home.session(name) as (database, row):
        found, missing = reports(database, row)
    titled = {name: (TITLES[name], report) for name, report in found.items()}
    if to is not None:
        _prepare_folder(to, list(found))
        for figure, (title, report) in titled.items():
            _store(to, figure, title, report)
        _store_page(to, f"Session {row['id']}", titled, missing)
    if as_json:
        print_json({name: report.rows for name, report in found.items()})
        return
    for title, report in titled.values():
        _print(console(), title, report)
    for sentence in missing:
        console().print(sentence, markup=False, soft_wrap=True)


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
            made.add_column(
                column.head, justify="right" if column.is_number else "left", overflow="fold"
            )
        for row in report.rows if report.seen is None else report.seen:
            add(made, *(column.show(row) for column in columns))
        out.print(made)
        out.print()
    for claim in report.claims:
        out.print(_verdict(claim.sentence, claim.against), markup=False, soft_wrap=True)
    out.print()


def _verdict(sentence: str, against: str) -> str:
    return f"✗ {sentence} But {against}." if against else f"✓ {sentence}"

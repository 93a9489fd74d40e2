"""``sar-tui export``: sessions as files that other programs read."""

import sys
from collections.abc import Callable, Mapping
from itertools import count
from pathlib import Path
from typing import Annotated

import typer

from sar_tui.cli.common import (
    AsJson,
    Everything,
    Home,
    Mixed,
    Sessions,
    SessionsOf,
    Simulated,
    console,
    named_path,
    print_json,
    warn_of_git,
    watch_plugins,
)
from sar_tui.cli.progress_line import progress_line
from sar_tui.cli.tables import Column, Listing, print_listing
from sar_tui.export.registry import names
from sar_tui.tui.exit_codes import FAILED


def export(
    context: typer.Context,
    home: Home,
    to: Annotated[
        Path | None,
        typer.Option(
            "--to",
            parser=named_path,
            metavar="DIR",
            show_default=False,
            help="The folder to make. It may exist if it is empty, or holds an earlier export, "
            "which is replaced. "
            "Default: a new one in the folder exports of the data folder.",
        ),
    ] = None,
    sessions: Sessions = None,
    participant: SessionsOf = None,
    everything: Everything = False,
    format: Annotated[
        str,
        typer.Option(
            "--format", metavar="NAME", help=f"The form of the files: {', '.join(names())}."
        ),
    ] = "csv",
    simulated: Simulated = False,
    mixed: Mixed = False,
    with_notes: Annotated[
        bool,
        typer.Option(
            "--with-notes", help="Also texts that somebody may have typed: notes, reasons, remarks."
        ),
    ] = False,
    with_events: Annotated[
        bool,
        typer.Option(
            "--with-events", help="Also a row for each message in the program, without its content."
        ),
    ] = False,
    recode: Annotated[
        Path | None,
        typer.Option(
            "--recode",
            parser=named_path,
            metavar="MAP.csv",
            show_default=False,
            help="Replace codes by random ones and shift dates. The file keeps both; it is made "
            "if it does not exist.",
        ),
    ] = None,
    recipient: Annotated[
        str,
        typer.Option("--for", metavar="TEXT", show_default=False, help="For whom, for the ledger."),
    ] = "",
    show_ledger: Annotated[
        bool, typer.Option("--ledger", help="List all exports instead: when, what, for whom.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Export sessions as files for other programs."""
    watch_plugins(context)
    if show_ledger:
        _print_ledger(home, as_json)
        return

    from sar_tui.drivers.login_name import login_name
    from sar_tui.export.export import Options, new_folder
    from sar_tui.export.export import export as write
    from sar_tui.export.registry import load
    from sar_tui.store.selection import Request

    request = Request(
        names=tuple(sessions or ()),
        participant=participant or "",
        everything=everything,
        simulated=simulated,
        mixed=mixed,
    )
    options = Options(
        with_notes=with_notes,
        with_events=with_events,
        recode=recode,
        recipient=recipient.strip(),
        author=login_name(),
    )
    with home.database() as database, progress_line("Exporting") as show:

        def start(steps: int) -> Callable[[], None]:
            done = count(1)
            return lambda: show("Exporting", next(done), steps)

        form = load(format)
        to = to or new_folder(home.folder, form, options)
        had_map = recode is None or recode.exists()
        try:
            exported = write(
                database, home.folder, home.catalogue(), request, form, to, start, options
            )
        except BaseException:
            if recode and not had_map and recode.exists():
                said = (
                    f"! {recode} was made, and nothing was exported with it. Keep it for the "
                    "next try, or delete it."
                )
                print(said, file=sys.stderr)
            raise
    for written in (to, *([recode] if recode else ())):
        warn_of_git(written)
    if as_json:
        print_json(exported)
    else:
        number = len(exported.sessions)
        console().print(f"{number} session{'' if number == 1 else 's'} in {to}", soft_wrap=True)
    for sentence in (*exported.notices, *exported.problems):
        console(error=True).print(f"! {sentence}", soft_wrap=True)
    if exported.problems:
        raise typer.Exit(FAILED)


def _print_ledger(home: Home, as_json: bool) -> None:
    """Print all exports, the newest first."""
    from sar_tui.store.exports import ledger
    from sar_tui.store.sessions import local_time

    with home.database() as database:
        entries = ledger(database)
    print_listing(
        Listing(
            "exports",
            empty="Nothing was exported yet.",
            columns=(
                Column("when", lambda entry: local_time(entry.exported_at)),
                Column("by", lambda entry: entry.exported_by),
                Column("for", lambda entry: entry.recipient),
                Column("format", lambda entry: entry.format),
                Column("sessions", lambda entry: len(entry.sessions), is_number=True),
                Column("with", lambda entry: _given(entry.options)),
                Column("manifest", lambda entry: entry.manifest[:12]),
            ),
        ),
        entries,
        as_json,
    )


def _given(options: Mapping[str, object]) -> str:
    return ", ".join(name.replace("_", " ") for name, given in options.items() if given)

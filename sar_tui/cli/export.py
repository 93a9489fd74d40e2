"""``sar-tui export``: sessions as files that other programs read."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from sar_tui.cli.common import AsJson, Data, Home, Tasks, console, named_path, print_json, progress_bar, watch_plugins
from sar_tui.export.registry import names
from sar_tui.tui.exit_codes import FAILED


def export(
    context: typer.Context,
    to: Annotated[
        Path,
        typer.Option(
            "--to",
            parser=named_path,
            metavar="DIR",
            show_default=False,
            help="The folder to make. It may exist if it is empty, or holds an earlier export, which is replaced.",
        ),
    ],
    sessions: Annotated[
        list[str] | None, typer.Argument(metavar="[SESSION|last]…", help="Ids, or their beginnings.")
    ] = None,
    participant: Annotated[
        str | None,
        typer.Option("-p", "--participant", metavar="CODE", show_default=False, help="Sessions of this participant."),
    ] = None,
    everything: Annotated[bool, typer.Option("--all", help="All sessions.")] = False,
    format: Annotated[
        str, typer.Option("--format", metavar="NAME", help=f"The form of the files: {', '.join(names())}.")
    ] = "csv",
    simulated: Annotated[bool, typer.Option("--simulated", help="Simulated sessions instead of live ones.")] = False,
    mixed: Annotated[bool, typer.Option("--mixed", help="Live and simulated sessions.")] = False,
    with_notes: Annotated[
        bool, typer.Option("--with-notes", help="Also texts that somebody may have typed: notes, reasons, remarks.")
    ] = False,
    with_events: Annotated[
        bool, typer.Option("--with-events", help="Also a row for each message in the program, without its content.")
    ] = False,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Export sessions as files for other programs."""
    from sar_tui.export.export import export as write
    from sar_tui.export.registry import load
    from sar_tui.export.selection import Request

    watch_plugins(context)
    home = Home.of(context, data, tasks)
    request = Request(
        names=tuple(sessions or ()),
        participant=participant or "",
        everything=everything,
        simulated=simulated,
        mixed=mixed,
    )
    with home.database() as database, progress_bar() as bar:

        def start(steps: int) -> Callable[[], None]:
            shown = bar.add_task("Exporting", total=steps)
            return lambda: bar.advance(shown)

        exported = write(
            database,
            home.folder,
            home.catalogue(),
            request,
            load(format),
            to,
            start,
            with_notes=with_notes,
            with_events=with_events,
        )
    if as_json:
        print_json(exported)
    else:
        count = len(exported.sessions)
        console().print(f"{count} session{'' if count == 1 else 's'} in {to}", soft_wrap=True)
    for sentence in exported.problems:
        console(error=True).print(f"! {sentence}", soft_wrap=True)
    if exported.problems:
        raise typer.Exit(FAILED)

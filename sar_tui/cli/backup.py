"""``sar-tui backup``: copy all recorded data."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from sar_tui.cli.common import AsJson, Data, Home, Tasks, named_path, print_json, warn_of_git
from sar_tui.cli.progress_line import progress_line
from sar_tui.tui.exit_codes import FAILED


def backup(
    context: typer.Context,
    to: Annotated[
        Path | None,
        typer.Option(
            "--to",
            parser=named_path,
            metavar="DIR|FILE",
            show_default=False,
            help="A folder, or the file to make. Default: the folder backups in the data folder.",
        ),
    ] = None,
    verify: Annotated[
        bool,
        typer.Option(
            "--verify", help="Restore the copy into an empty folder, and examine it there."
        ),
    ] = False,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Copy the database, also while a session goes on."""
    from sar_tui.store.backup import back_up, rehearse
    from sar_tui.store.rescue import rescue_files

    home = Home.of(context, data, tasks)
    with progress_line("Copying") as show:
        made = back_up(home.folder, to, partial(show, "Copying"))
    warn_of_git(made.path if to is None or to == made.path else to)
    left_out = rescue_files(home.folder)
    with progress_line("Trying the copy") as show:
        found = rehearse(made.path, partial(show, "Trying the copy")) if verify else []
    if as_json:
        whole = (
            {"verified": verify and not found, "flaws": [flaw._asdict() for flaw in found]}
            if verify
            else {}
        )
        rescue = [str(path) for path in left_out]
        print_json(
            {
                "file": str(made.path),
                "sessions": made.sessions,
                "bytes": made.bytes,
                "left_out": rescue,
                **whole,
            }
        )
    else:
        print(f"{made.sessions} session{'' if made.sessions == 1 else 's'} in {made.path}")
        for path in left_out:
            print(f"! {path} is not in it. `sar-tui rescue` brings its sessions into the database.")
        if verify and not found:
            print("It was restored into an empty folder: it opens there, and all of it is whole.")
        for flaw in found:
            print(f"✗ {f'{flaw.where}: ' if flaw.where else ''}{flaw.what}")
    if found:
        raise typer.Exit(FAILED)

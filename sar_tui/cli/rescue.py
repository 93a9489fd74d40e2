"""``sar-tui rescue``: bring back what rescue files hold."""

import sys
from pathlib import Path

import typer

from sar_tui.cli.check import missing_words
from sar_tui.cli.common import AsJson, Data, Home, Tasks, print_json
from sar_tui.cli.progress_line import progress_line
from sar_tui.tui.exit_codes import FAILED

_LISTED = 5
"""Damaged messages of a session that are named; JSON has all."""


def rescue(
    context: typer.Context, as_json: AsJson = False, data: Data = None, tasks: Tasks = None
) -> None:
    """Bring the sessions of rescue files back into the database.

    A rescue file is written if the database was removed during a session, or locked at its end.
    """
    from sar_tui.store.database import StoreError
    from sar_tui.store.rescue import bring_back, rescue_files

    home = Home.of(context, data, tasks)
    files = rescue_files(home.folder)
    try:
        with progress_line("Bringing back"):
            sessions = bring_back(home.folder) if files else []
    except StoreError:
        for path in files:
            print(f"! {path} waits, and is kept as it is. It holds {_held(path)}.", file=sys.stderr)
        raise
    if as_json:
        print_json({"sessions": [each._asdict() | {"file": str(each.file)} for each in sessions]})
    elif not files:
        print(f"There are no rescue files in {home.folder}.")
    for each in () if as_json else sessions:
        of = f"Session {each.session} of {each.participants} ({each.task})"
        print(
            f"{of} stays in {each.file}: {each.problem}."
            if each.problem
            else f"{of} is in the database again."
        )
        if each.damaged:
            numbers = ", ".join(map(str, each.damaged[:_LISTED])) + (
                " …" if len(each.damaged) > _LISTED else ""
            )
            print(
                f"! Messages of it that are damaged are left out: {len(each.damaged)} (number "
                f"{numbers})."
            )
        if each.missing:
            print(f"! The file is damaged. Missing: {missing_words(each.missing)}.")
    if files and not sessions and not as_json:
        print("The database has all that is in the rescue files.")
    if any(each.problem for each in sessions):
        raise typer.Exit(FAILED)


def _held(path: Path) -> str:
    """Return what a rescue file holds, in words."""
    from sar_tui.store.database import StoreError
    from sar_tui.store.rescue import waiting

    try:
        found = waiting(path)
    except StoreError as error:
        return f"what cannot be read now ({error})"
    return (
        "; ".join(
            f"session {each.session} of {each.participants} ({each.task}), {each.trials} "
            f"trial{'' if each.trials == 1 else 's'}"
            for each in found
        )
        or "no session"
    )

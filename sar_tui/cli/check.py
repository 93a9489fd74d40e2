"""``sar-tui check``: examine all recorded data."""

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from sar_tui.cli.common import AsJson, Data, Home, Tasks, print_json
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    from sar_tui.store.integrity import Flaw

_COUNTED = {"attempts": "attempts", "trials": "trials", "imu_chunks": "blocks of samples"}
"""Tables whose rows are told, with their names in the plural."""


def check(context: typer.Context, as_json: AsJson = False, data: Data = None, tasks: Tasks = None) -> None:
    """Check that all recorded data is whole: the file, its relations, its numbers, and the sensors' samples.

    Nothing is changed. A session may go on meanwhile.
    """
    from sar_tui.store.integrity import counts, flaws, interrupted
    from sar_tui.store.troubles import troubles

    home = Home.of(context, data, tasks)
    with home.database() as database:
        found = list(flaws(database))
        waiting = troubles(database, home.folder)
        is_readable = not any(flaw.kind == "file" for flaw in found)
        number = counts(database) if is_readable else {}
        stopped = interrupted(database, home.folder) if is_readable else []
    if as_json:
        print_json(
            {"flaws": [flaw._asdict() for flaw in found], "troubles": waiting, "rows": number, "interrupted": stopped}
        )
    else:
        _print(found, waiting, number, home.folder)
        for session in stopped:
            print(f"· {session}: This session was interrupted; what was recorded is here.")
    if found or waiting:
        raise typer.Exit(FAILED)


def _print(found: "list[Flaw]", waiting: list[str], number: dict[str, int], folder: Path) -> None:
    if not found and not waiting:
        counted = ", ".join(f"{number[table]} {words}" for table, words in _COUNTED.items() if number[table])
        print(f"All data in {folder} is whole{f' ({counted})' if counted else ''}.")
    for flaw in found:
        print(f"✗ {f'{flaw.where}: ' if flaw.where else ''}{flaw.what}")
    if any(flaw.kind == "file" for flaw in found):
        print("Copy the folder before anything else, and restore a backup.")

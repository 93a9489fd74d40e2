"""``sar-tui check``: examine all recorded data."""

from collections.abc import Iterable
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import AsJson, Data, Home, Tasks, print_json
from sar_tui.cli.errors import Refused
from sar_tui.cli.progress_line import progress_line
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    from sar_tui.store.integrity import Flaw
    from sar_tui.store.repair import Repair

_WORDS = {
    "seats": "participants",
    "imu_streams": "sensors",
    "imu_chunks": "blocks of samples",
    "log_hashes": "hashes of the log",
}
"""Tables whose missing rows are told in other words than their names."""
_COUNTED = {"attempts": "attempts", "trials": "trials", "imu_chunks": "blocks of samples"}
"""Tables whose rows are told, with their names in the plural."""


def check(
    context: typer.Context,
    mend: Annotated[
        bool,
        typer.Option(
            "--repair",
            help="Move what is damaged into a file beside the database, and make altered results "
            "again from the log. "
            "No other program may run.",
        ),
    ] = False,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Check that all recorded data is whole: the file, its relations, the sensors' samples, and
    what was recorded.

    Without --repair nothing is changed, and a session may go on meanwhile.
    """
    from sar_tui.store.database import FILE
    from sar_tui.store.integrity import counts, flaws, interrupted
    from sar_tui.store.repair import repair
    from sar_tui.store.troubles import may_have_any, troubles

    home = Home.of(context, data, tasks)
    if not ((home.folder / FILE).exists() or may_have_any(home.folder)):
        raise Refused(f"There is no data in {home.folder} yet.")
    with progress_line("Repairing"):
        done = repair(home.folder) if mend else None
    with home.database() as database, progress_line("Checking") as show:
        told = partial(show, "Checking")
        found = list(flaws(database, progress=told)) if done is None else done.flaws
        waiting = troubles(database, home.folder)
        is_readable = not any(flaw.kind == "file" for flaw in found)
        number = counts(database) if is_readable else {}
        stopped = interrupted(database, home.folder) if is_readable else []
    if as_json:
        print_json(
            {
                **({"repair": _as_json(done)} if done else {}),
                "flaws": [flaw._asdict() for flaw in found],
                "troubles": waiting,
                "rows": number,
                "interrupted": stopped,
            }
        )
    else:
        if done:
            _print_repair(done)
        _print(found, waiting, number, home.folder)
        for session in stopped:
            print(f"· {session}: This session was interrupted; what was recorded is here.")
    if found or waiting:
        raise typer.Exit(FAILED)


def _as_json(done: "Repair") -> dict[str, object]:
    files = {"backup": done.backup, "kept": done.kept, "aside": done.aside}
    return {
        **{name: path and str(path) for name, path in files.items()},
        "unread": [each._asdict() for each in done.unread],
        "moved": [each._asdict() for each in done.moved],
        "rebuilt": done.rebuilt,
        "missing": [each._asdict() for each in done.missing],
    }


def _print_repair(done: "Repair") -> None:
    if not done.kept and not done.moved:
        print("There is nothing to move aside, and nothing was changed.")
    if done.backup:
        print(f"A backup was made before: {done.backup}")
    if done.kept:
        print(f"All rows that can be read are in a new file. The damaged one is kept: {done.kept}")
    for table, first, last, session in done.unread:
        if not last:
            print(f"! {table}: Nothing can be read.")
            continue
        print(
            f"! {session or table}: {'events' if session else 'rows'} {first} to {last} cannot be "
            "read."
        )
    for table, rows, reason in done.moved:
        print(f"· {rows} of the rows of {table} moved aside: {reason}.")
    if done.aside:
        print(f"They are in {done.aside}.")
    for session, lacks in groupby(done.missing, key=lambda each: each.session):
        print(f"! {session}: Missing: {missing_words((each.table, each.rows) for each in lacks)}.")
    for session in done.rebuilt:
        print(f"· {session}: Its results were made again from its log.")


def missing_words(rows: Iterable[tuple[str, int]]) -> str:
    """Return what is missing of a session in words: "the session itself, 65 messages"."""
    return ", ".join(
        "the session itself" if t == "sessions" else f"{n} {_WORDS.get(t, t)}" for t, n in rows
    )


def _print(found: "list[Flaw]", waiting: list[str], number: dict[str, int], folder: Path) -> None:
    if not found and not waiting:
        counted = ", ".join(
            f"{number[table]} {words}" for table, words in _COUNTED.items() if number[table]
        )
        print(f"All data in {folder} is whole{f' ({counted})' if counted else ''}.")
    for flaw in found:
        print(f"✗ {f'{flaw.where}: ' if flaw.where else ''}{flaw.what}")
    if any(flaw.kind == "file" for flaw in found):
        print(
            "Copy the folder before anything else. Then restore a backup, or save what can be "
            "read: check --repair."
        )

"""``sar-tui backup``, ``check`` and ``rescue``: copy, examine and bring back recorded data."""

import sys
from collections.abc import Iterable
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import AsJson, Home, named_path, print_json, warn_of_git
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
_LISTED = 5
"""Damaged messages of a session that are named; JSON has all."""


def backup(
    home: Home,
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
) -> None:
    """Copy the database, also while a session goes on."""
    from sar_tui.store.backup import back_up, rehearse
    from sar_tui.store.rescue import rescue_files

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


def check(
    home: Home,
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
) -> None:
    """Check that all recorded data is whole: the file, its relations, the sensors' samples, and
    what was recorded.

    Without --repair nothing is changed, and a session may go on meanwhile.
    """
    from sar_tui.store.database import FILE
    from sar_tui.store.integrity import counts, flaws, interrupted
    from sar_tui.store.repair import repair
    from sar_tui.store.troubles import may_have_any, troubles

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
                **({"repair": _repair_as_json(done)} if done else {}),
                "flaws": [flaw._asdict() for flaw in found],
                "troubles": waiting,
                "rows": number,
                "interrupted": stopped,
            }
        )
    else:
        if done:
            _print_repair(done)
        _print_check(found, waiting, number, home.folder)
        for session in stopped:
            print(f"· {session}: This session was interrupted; what was recorded is here.")
    if found or waiting:
        raise typer.Exit(FAILED)


def _repair_as_json(done: "Repair") -> dict[str, object]:
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


def _print_check(
    found: "list[Flaw]", waiting: list[str], number: dict[str, int], folder: Path
) -> None:
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


def rescue(home: Home, as_json: AsJson = False) -> None:
    """Bring the sessions of rescue files back into the database.

    A rescue file is written if the database was removed during a session, or locked at its end.
    """
    from sar_tui.store.database import StoreError
    from sar_tui.store.rescue import bring_back, rescue_files

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

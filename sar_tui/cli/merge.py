"""``sar-tui merge`` and ``sar-tui site``: data of several sites in one database."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import AsJson, Home, named_path, print_json
from sar_tui.cli.errors import Refused
from sar_tui.cli.progress_line import progress_line
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    from sar_tui.store.merge.merge import Merged

_WORDS = {
    "participants": ("participant", "participants"),
    "programmes": ("version of a programme", "versions of programmes"),
    "records": ("version of a record", "versions of records"),
    "exports": ("export in the ledger", "exports in the ledger"),
    "people_events": ("use of a person's rights", "uses of people's rights"),
    "same_people": ("row of a person with two codes", "rows of persons with two codes"),
}
"""Tables whose changed rows are told, with the words for one and for several."""


def merge(
    home: Home,
    other: Annotated[
        Path | None,
        typer.Argument(
            parser=named_path,
            metavar="[OTHER.db]",
            help="The other database, or its data folder.",
            show_default=False,
        ),
    ] = None,
    same: Annotated[
        list[str] | None,
        typer.Option(
            "--same",
            metavar="CODE@SITE=CODE",
            show_default=False,
            help="Two codes of one person, such as P01@BERN=P01. May be repeated.",
        ),
    ] = None,
    site: Annotated[
        str,
        typer.Option(
            "--site",
            metavar="CODE",
            show_default=False,
            help="The other's site, if it has no code.",
        ),
    ] = "",
    one_site: Annotated[
        bool,
        typer.Option(
            "--one-site", help="Both are of one site, where a code stands for one person."
        ),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Bring what another database has into this one; without one, list what contradicts and who is
    the same person.

    The other database is only read, and a backup of this one is made.
    """
    from sar_tui.store.merge.merge import merge as merge_databases

    if other is None and (site or one_site):
        raise Refused(
            "--site and --one-site are about another database: name it, such as sar-tui merge "
            "bern.db."
        )
    with progress_line("Merging") as show:

        def start(step: str) -> Callable[[int, int], None]:
            show(step, 0, 0)
            return lambda done, total: show(step, done, total)

        merged = merge_databases(
            home.folder, other, same or (), site=site, one_site=one_site, start=start
        )
    if as_json:
        print_json(merged)
    else:
        _print(merged, other)
    if merged.left_out or merged.refused or merged.rescue_files:
        raise typer.Exit(FAILED)


def _print(merged: "Merged", other: Path | None) -> None:
    if other is not None:
        told = [
            _count(len(merged.added), ("new session", "new sessions")),
            _count(len(merged.updated), ("session that went on", "sessions that went on")),
            *(_count(merged.records.get(table, 0), words) for table, words in _WORDS.items()),
        ]
        found = ", ".join(filter(None, told))
        print(f"From {merged.other}: {found or 'nothing that this database did not have'}.")
    elif not (merged.same or merged.conflicts):
        print("Nothing contradicts, and nobody has two codes.")
    if merged.backup:
        print(f"As it was before: {merged.backup}")
    for code, same_as in merged.same:
        print(f"{code} is {same_as}.")
    for code in merged.erased:
        print(
            f"! {code} was erased or de-identified at their site, and so here. Backups still hold "
            f"the person: delete those that you no longer need."
        )
    for conflict in merged.conflicts:
        print(
            f"! Another version of the {conflict.kind} {conflict.key} is kept aside "
            f"({conflict.digest[:8]})."
        )
    for session in merged.left_out:
        print(
            f"! Session {session} is running there. It is left out: merge again when it has ended."
        )
    for sentence in merged.refused:
        print(f"! {sentence}")
    for path in merged.rescue_files:
        print(
            f"! {path} holds data that is not in that database. Run `sar-tui rescue` there, and "
            "merge again."
        )


def _count(number: int, words: tuple[str, str]) -> str:
    """Return "2 new sessions", or "1 new session"; empty for none."""
    return f"{number} {words[number != 1]}" if number else ""


def site(
    home: Home,
    code: Annotated[
        str | None,
        typer.Argument(metavar="CODE", help="The site's code, such as BERN.", show_default=False),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Show the code of this site, or set it. All that was recorded here belongs to it."""
    from sar_tui.store import sites

    if code is not None:
        code = sites.check_site(code)
        with home.writable_database() as database:
            before, now = sites.own(database), sites.set_own(database, code)
    else:
        with home.database() as database:
            before = now = sites.own(database)
    if as_json:
        print_json({"site": now})
    elif not now:
        print("This site has no code. Set it, for example to BERN: sar-tui site BERN")
    else:
        print(f"All that was recorded in {home.folder} belongs to the site {now}.")
        if before not in ("", now):
            print(
                f"It was {before}: whoever has data of {before} already must get it again, and "
                "remove the earlier."
            )

"""``sar-tui passphrase``: set or remove the therapist's passphrase, and list the tries."""

import getpass
import sys
from operator import attrgetter
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import AsJson, Home, is_interactive, print_json
from sar_tui.cli.errors import Refused

if TYPE_CHECKING:
    from sar_tui.store.passphrase import Passphrase


def passphrase(
    home: Home,
    remove: Annotated[bool, typer.Option("--remove", help="Remove the passphrase.")] = False,
    tries: Annotated[
        bool, typer.Option("--tries", help="List when it was entered, right or wrong.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Set the therapist's passphrase.

    It ends patient mode, and guards the therapist's choices in a pause. It is asked for twice, or
    read from standard input. Forgotten: set another one.
    """
    from sar_tui.store.passphrase import Passphrase

    stored = Passphrase(home.folder)
    if remove and tries:
        raise Refused("Give either --remove or --tries.")
    if tries:
        _list(stored, as_json=as_json)
        return
    if remove:
        stored.remove()
        done = (
            "There is no passphrase now: the therapist's choices in a pause are open, and "
            "patient mode cannot begin."
        )
    else:
        stored.set(_ask())
        done = (
            "The passphrase is set. Patient mode: sar-tui --patient CODE, or F12 on the first "
            "screen."
        )
    if as_json:
        print_json({"is_set": stored.is_set})
    else:
        print(done)


def _ask() -> str:
    if not is_interactive():
        if not (line := sys.stdin.readline()):
            raise Refused("Give the passphrase on standard input, as one line.")
        return line.rstrip("\r\n")
    text = getpass.getpass("New passphrase: ")
    if getpass.getpass("Once more: ") != text:
        raise Refused("The two differ. Nothing was changed.")
    return text


def _list(stored: "Passphrase", *, as_json: bool) -> None:
    from sar_tui.cli.tables import Column, Listing, print_listing
    from sar_tui.store.sessions import local_time

    if not as_json:
        print("A passphrase is set." if stored.is_set else "There is no passphrase.")
    print_listing(
        Listing(
            "tries",
            empty="No try is recorded.",
            columns=(
                Column("when", lambda each: local_time(each.at)),
                Column("result", attrgetter("result")),
                Column("where", attrgetter("where")),
            ),
        ),
        stored.tries(),
        as_json,
        is_set=stored.is_set,
    )

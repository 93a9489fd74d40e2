"""``sar-tui letterbox``: sealed letters between a clinic and the homes where people train."""

import sys
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sar_tui.cli.common import (
    AsJson,
    Code,
    Home,
    console,
    is_interactive,
    named_path,
    print_json,
)
from sar_tui.cli.errors import Refused
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    from sar_tui.letterbox.exchange import Exchanged
    from sar_tui.letterbox.status import Clinic
    from sar_tui.letterbox.status import Home as AtHome

app = typer.Typer(rich_markup_mode=None, no_args_is_help=True)

Folder = Annotated[
    Path | None,
    typer.Option(
        "--folder",
        parser=named_path,
        metavar="DIR",
        show_default=False,
        help="The letterbox: a folder that both sides reach.",
    ),
]


@app.callback()
def letterbox(home: Home) -> None:
    """Follow people who train at home, by sealed letters in a folder that both sides reach."""


# --- at the clinic


@app.command("new")
def new_letterbox(
    home: Home,
    clinic: Annotated[
        str,
        typer.Option(
            "--clinic",
            metavar="NAME",
            show_default=False,
            help="The clinic's name, which people at home read.",
        ),
    ],
    folder: Folder = None,
    as_json: AsJson = False,
) -> None:
    """Make a letterbox at the clinic, or move to another folder. Default: ~/sar-tui-letterbox."""
    from sar_tui.letterbox.letterbox import new
    from sar_tui.store.passphrase import Passphrase

    made = new(home.folder, clinic, folder)
    if as_json:
        print_json({"clinic": made.clinic, "folder": made.folder})
        return
    console().print(
        f"The letterbox of {made.clinic} is {made.folder}\n"
        "Share this folder with the homes, by Syncthing, Nextcloud, a network share or a stick. "
        "Then invite: sar-tui letterbox invite CODE",
        soft_wrap=True,
    )
    _tell_folder(home)
    if not Passphrase(home.folder).is_set:
        console().print("Before that, set your passphrase: sar-tui passphrase", soft_wrap=True)


def _tell_folder(home: Home) -> None:
    """Say where the data is: an app that is opened with another folder knows nothing of it."""
    console().print(f"The data is in {home.folder.absolute()}", soft_wrap=True)


@app.command()
def invite(
    home: Home,
    participant: Code,
    to: Annotated[
        Path | None,
        typer.Option(
            "--to",
            parser=named_path,
            metavar="FILE|DIR",
            show_default=False,
            help="Where to write the invitation. Default: into the letterbox.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Invite a person's computer at home: writes a sealed file, and prints the code that opens it.

    A second invitation is for another computer: of a home with two, or after one was lost.
    """
    from sar_tui.letterbox.letterbox import DAYS
    from sar_tui.letterbox.letterbox import invite as invite_home

    invited = invite_home(home.folder, participant, to)
    if as_json:
        print_json(
            {
                "name": invited.home.name,
                "file": str(invited.file),
                "code": invited.code,
                "expires": invited.home.expires_at,
            }
        )
        return
    console().print(
        f"Invitation of {invited.home.name}, for {DAYS} days: {invited.file}\n\n"
        f"    {invited.code}\n\n"
        "Tell them these eight words by phone; of each the first four letters are enough. Do not "
        "send them with the file.\n"
        "At home: sar-tui letterbox join FILE",
        soft_wrap=True,
    )


@app.command()
def message(
    home: Home,
    participant: Code,
    text: Annotated[
        str, typer.Argument(metavar="TEXT", help="What they read.", show_default=False)
    ],
    as_json: AsJson = False,
) -> None:
    """Write a message to a person at home, who reads it in large print before they train."""
    from sar_tui.letterbox.post import write_message

    _write(
        home, participant, lambda db, code, who: write_message(db, code, text, author=who), as_json
    )


@app.command()
def days(
    home: Home,
    participant: Code,
    weekdays: Annotated[
        list[str], typer.Argument(metavar="DAY…", help="Such as mon wed fri.", show_default=False)
    ],
    as_json: AsJson = False,
) -> None:
    """Plan the days of the week on which a person trains at home."""
    from sar_tui.letterbox.post import plan_days

    _write(
        home, participant, lambda db, code, who: plan_days(db, code, weekdays, author=who), as_json
    )


@app.command()
def ask(
    home: Home,
    participant: Code,
    form: Annotated[
        str,
        typer.Argument(
            metavar="FORM", help="`sar-tui record kinds` lists them.", show_default=False
        ),
    ],
    as_json: AsJson = False,
) -> None:
    """Ask a person to fill in a form at home; it is offered before they train."""
    from sar_tui.letterbox.post import request_form

    _write(
        home, participant, lambda db, code, who: request_form(db, code, form, author=who), as_json
    )


def _write(home: Home, participant: str, write: Any, as_json: bool) -> None:
    """Store what a clinic writes to a person, and send it."""
    from sar_tui.drivers.login_name import login_name
    from sar_tui.letterbox.exchange import exchange
    from sar_tui.letterbox.letterbox import find_home

    with home.writable_database() as database:
        code = find_home(home.folder, database, participant)
        record = write(database, code, login_name())
    done = exchange(home.folder)
    if as_json:
        print_json(record)
        return
    values = ", ".join(str(value) for value in record.content.values())
    console().print(f"To {code}: {values}", soft_wrap=True)
    _tell_troubles(done)


@app.command()
def revoke(
    home: Home,
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME", help="The person, or P07/2 of several computers.", show_default=False
        ),
    ],
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask.")] = False,
    as_json: AsJson = False,
) -> None:
    """Take no more letters from a home, such as one whose computer was stolen."""
    from sar_tui.letterbox.exchange import exchange
    from sar_tui.letterbox.letterbox import revoke as revoke_home

    if not yes and is_interactive():
        typer.confirm(f"No more letters from the computer of {name}?", abort=True, err=True)
    revoked = revoke_home(home.folder, name)
    done = exchange(home.folder)
    if as_json:
        print_json({"revoked": [one.name for one in revoked]})
        return
    for one in revoked:
        console().print(
            f"{one.name} is revoked: nothing is taken from that computer, and nothing written to "
            "it. What it has already stays readable there: the person's own sessions, programme "
            f"and messages. For another computer: sar-tui letterbox invite {one.participant}",
            soft_wrap=True,
        )
    _tell_troubles(done)


# --- at home


@app.command()
def join(
    home: Home,
    file: Annotated[
        Path,
        typer.Argument(
            parser=named_path, metavar="FILE", help="The invitation.", show_default=False
        ),
    ],
    folder: Folder = None,
    as_json: AsJson = False,
) -> None:
    """Train at home with this computer. Asks for the eight words that the therapist tells.

    The letterbox is the folder of the invitation, unless --folder names another one. From then on
    sar-tui opens this person's exercises.
    """
    from sar_tui.letterbox.exchange import exchange
    from sar_tui.letterbox.folder import LETTER, README, Letterbox
    from sar_tui.letterbox.letterbox import join as join_clinic
    from sar_tui.letterbox.letterbox import read_invitation

    sealed = read_invitation(file)
    place = folder or file.absolute().parent
    if folder is None and not (place / README).exists() and not list(place.glob(f"*{LETTER}")):
        raise Refused(
            f"{place} is no letterbox. Name the folder that is shared with the clinic: --folder DIR."
        )
    Letterbox(place)
    joined = join_clinic(home.folder, sealed, _ask_code(), place)
    if file.absolute().parent == joined.folder.absolute():
        Letterbox(joined.folder).remove(file.name)
    done = exchange(home.folder)
    if as_json:
        print_json(
            {
                "clinic": joined.clinic,
                "participant": joined.participant,
                "folder": str(joined.folder),
            }
        )
        return
    console().print(
        f"Welcome. This computer trains {joined.participant} for {joined.clinic} from now on.\n"
        "To train: sar-tui",
        soft_wrap=True,
    )
    _tell_folder(home)
    _tell_troubles(done)


_TRIES = 5
"""Times that the eight words are asked for."""


def _ask_code() -> str:
    """Return the eight words, typed or from standard input. Raises Refused, StoreError."""
    from sar_tui.letterbox.sealing import check_code
    from sar_tui.store.database import StoreError

    if not is_interactive():
        if not (line := sys.stdin.readline()):
            raise Refused("Give the eight words on standard input, as one line.")
        return check_code(line)
    print("The eight words that your therapist tells you (of each, 4 letters are enough):")
    for _ in range(_TRIES - 1):
        try:
            return check_code(input("> "))
        except StoreError as error:
            print(error)
    return check_code(input("> "))


# --- on both sides


@app.command()
def sync(home: Home, as_json: AsJson = False) -> None:
    """Take the letters that have arrived, and send those that are due. For cron: see the docs."""
    from sar_tui.letterbox.exchange import exchange

    done = exchange(home.folder)
    if as_json:
        print_json(done)
    else:
        taken = sum(count for _, count in done.taken)
        who = ", ".join(f"{name} {count}" for name, count in done.taken)
        said = [
            _count(taken, "letter taken", "letters taken") + (f" ({who})" if who else ""),
            _count(done.written, "written", "written"),
        ]
        if done.again:
            said.append(_count(done.again, "put there again", "put there again"))
        if done.doubled:
            said.append(_count(done.doubled, "came twice", "came twice"))
        console().print(f"{', '.join(said)}.", soft_wrap=True)
        for sentence in done.refused:
            console().print(f"! {sentence}", soft_wrap=True)
        _tell_troubles(done)
    if done.refused or done.troubles:
        raise typer.Exit(FAILED)


def _tell_troubles(done: "Exchanged") -> None:
    for sentence in done.troubles:
        print(f"! {sentence}", file=sys.stderr)


def _count(number: int, one: str, several: str) -> str:
    return f"{number} {one if number == 1 else several}"


@app.command("list")
def list_homes(home: Home, as_json: AsJson = False) -> None:
    """List the homes of a clinic, or at home what has arrived at the clinic."""
    from sar_tui.cli.tables import Column, Listing, print_listing
    from sar_tui.letterbox import status
    from sar_tui.letterbox.identity import require

    me = require(home.folder)
    with home.database() as database:
        if me.is_home:
            _print_clinic(me.clinic, status.clinic(database), as_json=as_json)
            return
        found = status.homes(database)
        files = database.execute(
            "SELECT name, refused FROM letter_files WHERE refused<>'' ORDER BY at, name"
        ).fetchall()
    print_listing(
        Listing(
            "homes",
            empty="Nobody trains at home. To invite somebody: sar-tui letterbox invite CODE",
            columns=(
                Column("name", attrgetter("name")),
                Column("state", attrgetter("state")),
                Column("heard", lambda one: one.heard_at[:10] or "never"),
                Column("missing", lambda one: ", ".join(map(str, one.missing))),
                Column("not acknowledged", lambda one: one.waiting or ""),
                Column("remarks", _remarks),
            ),
            folds=True,
            whole=("name", "state"),
        ),
        found,
        as_json,
    )
    if not as_json:
        for name, refused in files:
            console().print(f"! {name}: {refused}", soft_wrap=True)


def _remarks(one: "AtHome") -> str:
    said = list(one.refused)
    if one.clock:
        said.append(f"The clock at home is {one.clock}: {one.device.get('written_at', '')}")
    if one.state == "invited":
        said.append(f"The invitation ends on {one.expires_at[:10]}")
    return "\n".join(said)


def _print_clinic(clinic: str, found: "Clinic | None", *, as_json: bool) -> None:
    if as_json:
        print_json(found)
        return
    if found is None:
        console().print("Nothing has been exchanged yet.")
        return
    said = [f"{found.participant} trains here for {clinic}."]
    if found.state != "joined":
        said.append("! The clinic takes no letters from this computer. Ask for a new invitation.")
    said.append(f"Heard of the clinic: {found.heard_at[:10] or 'never yet'}.")
    if found.arrived:
        said.append(f"Arrived there: all up to the training of {found.arrived}.")
    if found.waiting:
        said.append(
            f"{_count(found.waiting, 'letter is', 'letters are')} on the way, the oldest since "
            f"{found.since[:10]}."
        )
    if found.refused:
        said.append(
            f"! The clinic has refused {_count(found.refused, 'letter', 'letters')}. Call your "
            "therapist: letterbox list there says why."
        )
    if found.missing:
        said.append(f"! Letters of the clinic are missing: {', '.join(map(str, found.missing))}.")
    console().print("\n".join(said), soft_wrap=True)

"""``sar-tui link``: manages invitations to sessions from another machine, and to visits at home."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any, cast, get_args

import typer

from sar_tui.cli.common import (
    AsJson,
    Home,
    console,
    named_path,
    print_json,
    warn_of_git,
)
from sar_tui.cli.errors import Refused
from sar_tui.cli.tables import Column, Listing, print_listing
from sar_tui.tui.exit_codes import FAILED

app = typer.Typer(rich_markup_mode=None, no_args_is_help=True)


@app.callback()
def link(home: Home) -> None:
    """Invite an operator or observer on another machine, or a home; list, revoke and check
    invitations; run a router for visits.
    """


@app.command()
def invite(
    home: Home,
    role: Annotated[
        str,
        typer.Argument(
            metavar="ROLE",
            show_default=False,
            help="operator (watches and acts), observer (watches, and can stop the agent), or home "
            "(a participant's computer, which dials out to the router).",
        ),
    ],
    name: Annotated[
        str,
        typer.Option(
            "--name",
            metavar="NAME",
            show_default=False,
            help="Their name in the record, such as op1.",
        ),
    ],
    host: Annotated[
        list[str],
        typer.Option(
            "--host",
            metavar="HOST[:PORT]",
            show_default=False,
            help="This machine's name or address on their network. May be repeated.",
        ),
    ],
    router: Annotated[
        bool,
        typer.Option(
            "--router",
            help="The host is the router: the operator or observer visits homes through it.",
        ),
    ] = False,
    days: Annotated[
        int, typer.Option("--days", metavar="N", help="Days until it expires, at most 366.")
    ] = 30,
    to: Annotated[
        Path | None,
        typer.Option(
            "--to",
            parser=named_path,
            metavar="FILE",
            show_default=False,
            help="The file to write. Default: ROLE-NAME.sar-link.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Create an invitation: a file that lets a person join sessions from another machine.

    The file is a key: treat it like a password. It is valid for sessions of this data folder that
    are started with --listen from now on; with --router, and for a home, for this data folder's
    router.
    """
    from sar_tui.link.authority import Authority
    from sar_tui.link.invitation import check_name, file_name, write
    from sar_tui.link.zenoh_settings import Guest, InvitedAs, parse_endpoint

    known = get_args(InvitedAs)
    if role not in known:
        raise Refused(f"There is no role {role}. Choose one of: {', '.join(known)}.")
    check_name(name)
    guest = Guest(name, cast(InvitedAs, role))
    path = to or Path(file_name(guest))
    if path.exists():
        raise Refused(f"{path} already exists. Give another name with --to.")
    if not path.resolve().parent.is_dir():
        raise Refused(f"{path} cannot be created: there is no folder {path.parent}.")
    where = [parse_endpoint(text) for text in host]
    authority = Authority.open_or_create(home.folder)
    invitation = authority.invite(guest, where, days, router=router)
    try:
        write(invitation, path)
    except BaseException:
        authority.forget(guest)
        raise
    warn_of_git(path)
    if as_json:
        print_json(
            {
                "file": str(path),
                "role": role,
                "name": name,
                "endpoints": invitation.endpoints,
                "expires": invitation.expires,
            }
        )
        return
    there = f"link home {path.name}" if role == "home" else f"wizard --link {path.name}"
    here = "link router" if invitation.router else "run TASK -p CODE"
    console().print(
        f"Created {path}, valid until {invitation.expires:%Y-%m-%d}. Anyone who has this file can "
        f"join as {name}.\n"
        f"Copy it to the other machine, and run there:  sar-tui {there}\n"
        f"Run here:  sar-tui {here} --listen tls/0.0.0.0:{where[0].port}",
        markup=False,
        soft_wrap=True,
    )


@app.command("list")
def list_invitations(home: Home, as_json: AsJson = False) -> None:
    """List all invitations."""
    from sar_tui.link.authority import Authority

    folder = home.folder
    invitations = Authority.open(folder).invitations if Authority.exists(folder) else ()
    now = datetime.now(UTC)
    rows: list[dict[str, Any]] = [
        {
            "name": issued.name,
            "role": issued.role,
            "state": issued.state(now),
            "endpoints": issued.endpoints,
            "issued": issued.issued,
            "expires": issued.expires,
            "revoked": issued.revoked,
            "fingerprint": issued.fingerprint,
        }
        for issued in invitations
    ]
    print_listing(
        Listing(
            "invitations",
            empty="Nobody is invited. To invite someone: sar-tui link invite operator --name NAME "
            "--host HOST",
            columns=(
                Column("name", lambda row: row["name"]),
                Column("role", lambda row: row["role"]),
                Column("state", lambda row: row["state"]),
                Column("expires", lambda row: f"{row['expires']:%Y-%m-%d}"),
                Column("host", lambda row: ", ".join(row["endpoints"])),
            ),
            folds=True,
            whole=("name", "role", "state"),
        ),
        rows,
        as_json,
    )


@app.command()
def revoke(
    home: Home,
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="Name of the guest.", show_default=False)
    ],
    as_json: AsJson = False,
) -> None:
    """Revoke an invitation, for sessions that start from now on."""
    from sar_tui.link.authority import Authority

    revoked = Authority.open(home.folder).revoke(name)
    if as_json:
        print_json({"name": revoked.name, "role": revoked.role, "revoked": revoked.revoked})
        return
    console().print(
        f"Revoked the invitation of {revoked.name}. Sessions that already run still accept it: "
        "end them to be sure. `sar-tui link router` refuses it within seconds.",
        markup=False,
        soft_wrap=True,
    )


@app.command()
def check(
    home: Home,
    file: Annotated[
        Path,
        typer.Argument(
            parser=named_path, metavar="FILE", help="The invitation.", show_default=False
        ),
    ],
    as_json: AsJson = False,
) -> None:
    """Check whether an invitation is valid, and whether a session, or the router, accepts it now.

    Exits with 1 if none does.
    """
    from sar_tui.link.client import probe
    from sar_tui.link.errors import LinkError
    from sar_tui.link.invitation import read
    from sar_tui.link.zenoh_settings import home_link, network_settings

    invitation = read(file)
    link, guest = invitation.link, ""
    if invitation.router:
        own_home = invitation.name if invitation.role == "home" else "-"
        link, guest = home_link(link, own_home), str(invitation.guest)
    attempts: list[dict[str, str]] = []
    for where in invitation.where:
        try:
            settings = network_settings(
                where, invitation.credentials, through_router=invitation.router
            )
            probe(settings, link, guest)
        except LinkError as error:
            attempts.append({"endpoint": str(where), "error": str(error)})
        else:
            attempts.append({"endpoint": str(where), "error": ""})
    if as_json:
        who = {"role": invitation.role, "name": invitation.name, "expires": invitation.expires}
        print_json({**who, "endpoints": attempts})
    else:
        out = console()
        out.print(
            f"The invitation of {invitation.name}, as {invitation.role}, is valid until "
            f"{invitation.expires:%Y-%m-%d at %H:%M} UTC.",
            markup=False,
            soft_wrap=True,
        )
        for tried in attempts:
            who_accepts = "The router" if invitation.router else "A session"
            mark, text = (
                ("✗", tried["error"])
                if tried["error"]
                else ("✓", f"{who_accepts} there accepts it.")
            )
            out.print(f"{mark} {tried['endpoint']}: {text}", markup=False, soft_wrap=True)
    if all(tried["error"] for tried in attempts):
        raise typer.Exit(FAILED)


@app.command()
def router(
    home: Home,
    listen: Annotated[
        str,
        typer.Option(
            "--listen",
            metavar="tls/HOST[:PORT]",
            show_default=False,
            help="Where to listen: tls/0.0.0.0 on every network. The port is 7447 unless given.",
        ),
    ],
    zenohd: Annotated[
        bool,
        typer.Option("--zenohd", help="Print the configuration for zenohd instead, and end."),
    ] = False,
) -> None:
    """Run the router, to which homes dial out, and through which operators visit them.

    It admits those whom `sar-tui link invite` of this data folder has invited, and follows new and
    revoked invitations. Ctrl-C ends it.
    """
    import signal
    import sys
    import threading

    from sar_tui.link.authority import Authority
    from sar_tui.link.router import run_router, settings_of
    from sar_tui.link.zenoh_settings import parse_endpoint

    where = parse_endpoint(listen)
    authority = Authority.open(home.folder)
    if zenohd:
        print(settings_of(authority, [where]))
        return
    ended = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.set())

    def report(text: str) -> None:
        print(text, file=sys.stderr, flush=True)

    guests = authority.guests()
    homes = sum(guest.role == "home" for guest in guests)
    report(
        f"The router listens on {where}, for {_count(homes, 'home')} and "
        f"{_count(len(guests) - homes, 'operator or observer', 'operators and observers')}. "
        "Ctrl-C ends it."
    )
    run_router(authority, [where], report, ended)


def _count(number: int, one: str, many: str = "") -> str:
    return f"{number} {one if number == 1 else many or one + 's'}"


@app.command("home")
def dial_out(
    home: Home,
    file: Annotated[
        Path | None,
        typer.Argument(
            parser=named_path,
            metavar="[FILE]",
            help="The invitation for this home.",
            show_default=False,
        ),
    ] = None,
    remove: Annotated[
        bool, typer.Option("--remove", help="Remove the invitation: no session dials out.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Keep the invitation of this home, so that its sessions dial out to the clinic's router.

    A therapist there can then ask to watch; the participant is asked on the screen. Without a FILE
    it says whether sessions dial out.
    """
    from sar_tui.link import visits
    from sar_tui.link.invitation import home_file, read

    if remove and file is not None:
        raise Refused("Give a FILE to keep, or --remove, not both.")
    kept = None
    if file is not None:
        kept = visits.keep_home(home.folder, file)
    elif remove:
        visits.remove_home(home.folder)
    elif home_file(home.folder).is_file():
        kept = read(home_file(home.folder))
    if as_json:
        print_json(
            {
                "dials_out": kept is not None,
                "name": kept.name if kept else None,
                "endpoints": kept.endpoints if kept else (),
                "expires": kept.expires if kept else None,
            }
        )
        return
    text = "No session of this data folder dials out."
    if kept:
        text = (
            f"Sessions of this data folder dial out to {', '.join(kept.endpoints)}, as the home "
            f"{kept.name}, until {kept.expires:%Y-%m-%d}. Nobody sees a session before the "
            "participant has agreed to it on the screen."
        )
        if file is not None:
            text += f"\nDelete {file}: it is a key. To end this: sar-tui link home --remove"
    console().print(text, markup=False, soft_wrap=True)

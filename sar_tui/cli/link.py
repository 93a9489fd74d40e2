"""``sar-tui link``: manages invitations to sessions from another machine."""

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
    """Invite an operator or observer on another machine; list, revoke and check invitations."""


@app.command()
def invite(
    home: Home,
    role: Annotated[
        str,
        typer.Argument(
            metavar="ROLE",
            show_default=False,
            help="operator (watches and acts) or observer (watches, and can stop the agent).",
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
    are started with --listen from now on.
    """
    from sar_tui.link.authority import Authority
    from sar_tui.link.invitation import check_name, file_name, write
    from sar_tui.link.zenoh_settings import Guest, parse_endpoint
    from sar_tui.model.messages import Role

    known = get_args(Role)
    if role not in known:
        raise Refused(f"There is no role {role}. Choose one of: {', '.join(known)}.")
    check_name(name)
    guest = Guest(name, cast(Role, role))
    path = to or Path(file_name(guest))
    if path.exists():
        raise Refused(f"{path} already exists. Give another name with --to.")
    if not path.resolve().parent.is_dir():
        raise Refused(f"{path} cannot be created: there is no folder {path.parent}.")
    where = [parse_endpoint(text) for text in host]
    authority = Authority.open_or_create(home.folder)
    invitation = authority.invite(guest, where, days)
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
    port = where[0].port
    console().print(
        f"Created {path}, valid until {invitation.expires:%Y-%m-%d}. Anyone who has this file can "
        f"join as {name}.\n"
        f"Copy it to the other machine, and run there:  sar-tui wizard --link {path.name}\n"
        f"Run here:  sar-tui run TASK -p CODE --listen tls/0.0.0.0:{port}",
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
        "end them to be sure.",
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
    """Check whether an invitation is valid, and whether a session accepts it now.

    Exits with 1 if no session does.
    """
    from sar_tui.link.client import probe
    from sar_tui.link.errors import LinkError
    from sar_tui.link.invitation import read
    from sar_tui.link.zenoh_settings import network_settings

    invitation = read(file)
    attempts: list[dict[str, str]] = []
    for where in invitation.where:
        try:
            probe(network_settings(where, invitation.credentials), invitation.link)
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
            mark, text = (
                ("✗", tried["error"]) if tried["error"] else ("✓", "A session there accepts it.")
            )
            out.print(f"{mark} {tried['endpoint']}: {text}", markup=False, soft_wrap=True)
    if all(tried["error"] for tried in attempts):
        raise typer.Exit(FAILED)

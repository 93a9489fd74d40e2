"""``sar-tui link``: who may watch or steer sessions from another machine."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any, cast, get_args

import typer

from sar_tui.cli.common import AsJson, Data, Home, Tasks, console, print_json
from sar_tui.cli.errors import FAILED, Refused

app = typer.Typer(rich_markup_mode=None, no_args_is_help=True)


@app.callback()
def link(context: typer.Context, data: Data = None, tasks: Tasks = None) -> None:
    """Invite an operator or an observer on another machine; see who is invited, and take it back."""
    context.obj = Home.of(context, data, tasks)


@app.command()
def invite(
    context: typer.Context,
    role: Annotated[
        str,
        typer.Argument(
            metavar="ROLE", show_default=False, help="operator, who watches and acts; or observer, who only watches."
        ),
    ],
    name: Annotated[
        str, typer.Option("--name", metavar="NAME", show_default=False, help="Who they are in the record: anna.")
    ],
    host: Annotated[
        list[str],
        typer.Option(
            "--host",
            metavar="HOST[:PORT]",
            show_default=False,
            help="This machine's name or address, as theirs can reach it. May be repeated.",
        ),
    ],
    days: Annotated[int, typer.Option("--days", metavar="N", help="For how long it is good, at most 366.")] = 30,
    to: Annotated[
        Path | None,
        typer.Option("--to", metavar="FILE", show_default=False, help="The file; else ROLE-NAME.sar-link, here."),
    ] = None,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Make the one file that lets somebody join sessions from another machine.

    The file is a key: hand it over as you would a password. It opens the sessions of this data folder that are run
    with --listen from now on.
    """
    from sar_tui.framework.messages import Role
    from sar_tui.link.authority import Authority
    from sar_tui.link.invitation import file_name, write
    from sar_tui.link.settings import Guest, parse_endpoint

    known = get_args(Role)
    if role not in known:
        raise Refused(f"There is no role {role}. There is: {', '.join(known)}.")
    guest = Guest(name, cast(Role, role))
    path = to or Path(file_name(guest))
    if path.exists():
        raise Refused(f"{path} is there already, and is left as it is. Give another name with --to.")
    if not path.resolve().parent.is_dir():
        raise Refused(f"{path} cannot be made: there is no folder {path.parent}.")
    where = [parse_endpoint(text) for text in host]
    authority = Authority.open_or_create(Home.of(context, data, tasks).folder)
    invitation = authority.invite(guest, where, days)
    try:
        write(invitation, path)
    except BaseException:
        authority.forget(guest)
        raise
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
        f"Made {path}, good until {invitation.expires:%Y-%m-%d}. It is a key: whoever has it is {name}.\n"
        f"Carry it to the other machine, and there:  sar-tui wizard --link {path.name}\n"
        f"Here:  sar-tui run TASK -p CODE --listen tls/0.0.0.0:{port}",
        markup=False,
        soft_wrap=True,
    )


@app.command("list")
def list_invitations(context: typer.Context, as_json: AsJson = False, data: Data = None, tasks: Tasks = None) -> None:
    """List who is invited, and until when."""
    from sar_tui.link.authority import Authority

    folder = Home.of(context, data, tasks).folder
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
    if as_json:
        print_json({"invitations": rows})
        return
    if not rows:
        console().print("Nobody is invited. To begin: sar-tui link invite operator --name NAME --host HOST")
        return

    from sar_tui.cli.tables import add, table

    made = table("name", "role", "state", "expires", "host", whole=("name", "role", "state"))
    for row in rows:
        add(made, row["name"], row["role"], row["state"], f"{row['expires']:%Y-%m-%d}", ", ".join(row["endpoints"]))
    console().print(made)


@app.command()
def revoke(
    context: typer.Context,
    name: Annotated[str, typer.Argument(metavar="NAME", help="Who is let in no longer.", show_default=False)],
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Take an invitation back: it opens no session that begins from now on."""
    from sar_tui.link.authority import Authority

    revoked = Authority.open(Home.of(context, data, tasks).folder).revoke(name)
    if as_json:
        print_json({"name": revoked.name, "role": revoked.role, "revoked": revoked.revoked})
        return
    console().print(
        f"{revoked.name} is let in no longer. A session that is running now knew them already: end it to be sure.",
        markup=False,
        soft_wrap=True,
    )


@app.command()
def check(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The invitation.", show_default=False)],
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """See whether an invitation is good, and whether the session it leads to lets you in now.

    Ends with 1 where no session does.
    """
    from sar_tui.link.errors import LinkError
    from sar_tui.link.invitation import read
    from sar_tui.link.probe import probe
    from sar_tui.link.settings import network_settings

    invitation = read(file)
    tries: list[dict[str, str]] = []
    for where in invitation.where:
        try:
            probe(network_settings(where, invitation.credentials), invitation.link)
        except LinkError as error:
            tries.append({"endpoint": str(where), "error": str(error)})
        else:
            tries.append({"endpoint": str(where), "error": ""})
    if as_json:
        who = {"role": invitation.role, "name": invitation.name, "expires": invitation.expires}
        print_json({**who, "endpoints": tries})
    else:
        out = console()
        out.print(
            f"The invitation of {invitation.name}, as {invitation.role}, is good until "
            f"{invitation.expires:%Y-%m-%d at %H:%M} UTC.",
            markup=False,
            soft_wrap=True,
        )
        for tried in tries:
            mark, words = ("✗", tried["error"]) if tried["error"] else ("✓", "A session there lets you in.")
            out.print(f"{mark} {tried['endpoint']}: {words}", markup=False, soft_wrap=True)
    if all(tried["error"] for tried in tries):
        raise typer.Exit(FAILED)

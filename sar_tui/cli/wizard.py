"""``sar-tui wizard`` and ``sar-tui agent``: views of a session that runs in another terminal, or on
another machine.
"""

import os
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import Home, Protocol, console, named_path, need_screen, write_new
from sar_tui.cli.errors import Refused

if TYPE_CHECKING:
    import asyncio

    from sar_tui.link.client import Where
    from sar_tui.link.discovery import JoinableSession
    from sar_tui.link.peer import Peer, PeerListener
    from sar_tui.model.messages import Role
    from sar_tui.model.protocol import WizardProtocol


Joined = Annotated[
    str | None,
    typer.Argument(
        metavar="SESSION",
        help="The session's id, or its beginning; through a router, the home.",
        show_default=False,
    ),
]
JoinedOrPractise = Annotated[
    str | None,
    typer.Argument(
        metavar="[SESSION|practise]",
        help="The session's id, or its beginning; through a router, the home; practise: play a "
        "recorded session.",
        show_default=False,
    ),
]
Link = Annotated[
    Path | None,
    typer.Option(
        "--link",
        parser=named_path,
        metavar="FILE",
        show_default=False,
        help="Invitation to a session on another machine, or to homes through a router.",
    ),
]


_PRACTISE = "practise"
"""In place of a session's id: play a recorded one. No id begins with it."""
_ONE_SESSION = "An invitation is for one session: leave out SESSION and --wait."
_NAME = "agent"
"""Name of the view in the session's log; the process id is appended, as there can be several."""


def wizard(
    home: Home,
    session: JoinedOrPractise = None,
    recorded: Annotated[
        str | None,
        typer.Argument(
            metavar="[RECORDED]",
            help="The recorded session to practise on: its id, or last.",
            show_default=False,
        ),
    ] = None,
    link: Link = None,
    name: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            show_default=False,
            help="Your name in the record. Default: your login name.",
        ),
    ] = None,
    observe: Annotated[bool, typer.Option("--observe", help="Only watch.")] = False,
    wait: Annotated[bool, typer.Option("--wait", help="Wait for a session to join.")] = False,
    protocol: Protocol = None,
    speed: Annotated[
        float | None,
        typer.Option(
            metavar="TIMES",
            min=0.25,
            max=16,
            show_default=False,
            help="Speed of practice while nothing waits for you. Default: 1.",
        ),
    ] = None,
    to: Annotated[
        Path | None,
        typer.Option(
            "--to",
            parser=named_path,
            metavar="FILE",
            show_default=False,
            help="Write the result of practice as JSON.",
        ),
    ] = None,
) -> None:
    """Open the operator's panel: watch a session and control it; or practise on a recorded one.

    The session runs in another terminal with --operator, on another machine with --listen, or at
    home, where the participant is asked first. F1 shows all keys. Practice writes nothing into the
    recorded session.
    """
    if session == _PRACTISE:
        if link or observe or wait:
            raise Refused("Practice joins no session: leave out --link, --observe and --wait.")
        _practise(home, recorded, protocol, name, speed or 1.0, to)
        return
    if recorded is not None or speed is not None or to is not None:
        raise Refused(
            "RECORDED, --speed and --to are for practice: sar-tui wizard practise SESSION "
            "--protocol FILE."
        )
    if protocol and observe:
        raise Refused("--protocol is for an operator: an observer does nothing by it.")
    followed = read_protocol(protocol) if protocol else None
    where = session_to_show(session, link, home.folder, wait=wait, observe=observe)
    name = name_at_session(name, link, observe=observe)
    need_screen()
    from sar_tui.operator.app import WizardApp, run_wizard
    from sar_tui.plugins import DEFAULT_THEME

    theme = home.catalogue().theme(DEFAULT_THEME)
    role: Role = "observer" if observe else "operator"
    app = WizardApp(theme, home.folder, name, role, where, waits=wait, protocol=followed)
    raise typer.Exit(run_wizard(app, lambda text: print(text, file=sys.stderr)))


def _practise(
    home: Home,
    recorded: str | None,
    protocol: Path | None,
    name: str | None,
    speed: float,
    to: Path | None,
) -> None:
    """Play a recorded session on the panel, and report how the trainee decided."""
    if recorded is None or protocol is None:
        raise Refused(
            "Practice needs a recorded session and a protocol: sar-tui wizard practise SESSION "
            "--protocol FILE."
        )
    followed = read_protocol(protocol)
    name = name_at_session(name, None, observe=False)
    if to is not None and to.exists():
        raise Refused(f"{to} exists already, and is not overwritten. Name another file.")
    need_screen()
    from sar_tui.cli.report import print_sections
    from sar_tui.operator.practice import sections
    from sar_tui.operator.practice_app import PracticeApp, recorded_practice
    from sar_tui.operator.practice_log import note_practice
    from sar_tui.plugins import DEFAULT_THEME

    catalogue = home.catalogue()
    with home.session(recorded) as (database, row):
        practice = recorded_practice(
            database, home.folder, catalogue, row, f"operator.{name}", followed, speed
        )
    app = PracticeApp(catalogue.theme(DEFAULT_THEME), home.folder, practice)
    code = app.run_here()
    if app.failure:
        print(app.failure, file=sys.stderr)
        raise typer.Exit(code)
    result = practice.result()
    print_sections(console(), sections(result))
    if to is not None:
        import msgspec

        write_new(to, msgspec.json.encode(result).decode() + "\n")
    if result.is_complete:
        note_practice(home.folder, name, result.session, followed)
    raise typer.Exit(code)


def agent(
    home: Home,
    session: Joined = None,
    link: Link = None,
) -> None:
    """Show the agent alone: its face, speech and gestures.

    It follows a session that was started with --operator or --listen, and cannot act.
    """
    catalogue = home.catalogue()
    where = session_to_join(session, link, home.folder)
    need_screen()
    from sar_tui.app.agent.app import AgentApp
    from sar_tui.link.client import connect
    from sar_tui.plugins import DEFAULT_THEME

    def join(listener: "PeerListener", loop: "asyncio.AbstractEventLoop") -> "Peer":
        return connect(where, f"{_NAME}-{os.getpid()}", "observer", listener, loop)

    app = AgentApp(catalogue.theme(DEFAULT_THEME), join)
    code = app.run_here()
    if app.failure:
        print(app.failure, file=sys.stderr)
    raise typer.Exit(code)


def read_protocol(path: Path) -> "WizardProtocol":
    """Read an operator's protocol. Raises Refused with its mistakes, one a line."""
    from sar_tui.operator.phrases import PHRASE_KEYS
    from sar_tui.rules.protocol_file import ProtocolMistakes, parse

    try:
        return parse(path.read_bytes(), PHRASE_KEYS)
    except OSError as error:
        raise Refused(f"{path} cannot be read: {error.strerror}.") from error
    except ProtocolMistakes as error:
        raise Refused("\n".join(f"{path}, {each}" for each in error.mistakes)) from error


def session_to_show(
    session: str | None, link: Path | None, data: Path, *, wait: bool, observe: bool
) -> "Where | None":
    """Return the session of a data folder to join, or None if the user must choose one or wait. Of
    an invitation to a router without a SESSION, return the invitation: the user chooses a home.

    Raises:
        Refused: there is no such session.
        LinkError: it cannot be joined from here.
    """
    from sar_tui.link.discovery import joinable_sessions
    from sar_tui.link.errors import need_packages

    if link is not None:
        from sar_tui.link.invitation import read

        if wait:
            raise Refused(_ONE_SESSION)
        need_packages()
        invitation = read(link)
        if session and not invitation.router:
            raise Refused(_ONE_SESSION)
        is_choice = invitation.router and session is None and invitation.role != "home"
        where = invitation if is_choice else session_to_join(session, link, data)
        if observe and invitation.role == "operator":
            raise Refused(
                f"{link} invites an operator, who can act. To only watch, ask for an observer's "
                "invitation."
            )
        return where
    if session is None:
        need_packages()
        found = joinable_sessions(data)
        if len(found) > 1 or (wait and not found):
            return None
    return session_to_join(session, None, data)


def name_at_session(name: str | None, link: Path | None, *, observe: bool) -> str:
    """Return the user's name at the session. An observer's default is unique, because a user may
    open several.
    """
    from sar_tui.link.invitation import NAME

    if name is None:
        from sar_tui.operator.app import own_name

        return f"{own_name()[:20]}-{os.getpid()}" if observe else own_name()
    if link is not None:
        raise Refused("An invitation contains your name: leave out --name.")
    if not re.fullmatch(NAME, name):
        raise Refused(f"{name!r} is not a valid name: use at most 32 letters, digits, - and _.")
    return name


def session_to_join(session: str | None, link: Path | None, data: Path) -> "Where":
    """Return the session of a data folder given by its id or the start of it, the only one there,
    or an invitation's; of an invitation to a router, that of a home.

    Raises:
        Refused: there is no such session, or there are several.
        LinkError: the invitation cannot be used, or packages of the link are not installed.
    """
    from sar_tui.link.errors import need_packages
    from sar_tui.link.invitation import read

    need_packages()
    if link is None:
        return _one(data, session)
    invitation = read(link)
    if invitation.role == "home":
        raise Refused(f"{link} is for a home, and no panel can use it: sar-tui link home {link}")
    if not invitation.router:
        return invitation
    if not session:
        raise Refused(f"{link} leads to a router. Name the home to visit, as SESSION.")
    from sar_tui.link.invitation import check_name
    from sar_tui.link.visits import HomeVisit

    check_name(session)
    return HomeVisit(invitation, session)


def _one(data: Path, session: str | None) -> "JoinableSession":
    from sar_tui.link.discovery import joinable_sessions, other_folders

    live = joinable_sessions(data)
    if session == "":
        raise Refused("The session's id is missing: it is empty.")
    meant = [each for each in live if each.session.startswith(session or "")]
    if not live and (others := other_folders(data)):
        raise Refused(
            f"No session of {data} can be joined. There is one of another data folder: to join "
            "it, add --data "
            f"{others[0]}."
        )
    if not live:
        raise Refused(
            "No session on this machine can be joined. Start one with --operator, as in "
            "`sar-tui run keyboard -p P01 --operator`. Sessions of other users, or with another "
            "XDG_RUNTIME_DIR, are "
            "not found."
        )
    there = "; ".join(f"{each.session} ({each.description()})" for each in live)
    if not meant:
        raise Refused(f"No session that can be joined begins with {session}. These can: {there}.")
    if len(meant) > 1:
        raise Refused(f"Several sessions can be joined: {there}. Give the id of one.")
    return meant[0]

"""``sar-tui wizard``: the operator's panel of a session that runs in another terminal, or on
another machine.
"""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import Data, Home, Tasks, need_screen
from sar_tui.cli.errors import Refused
from sar_tui.cli.session_choice import Joined, Link

if TYPE_CHECKING:
    from sar_tui.link.discovery import JoinableSession
    from sar_tui.link.invitation import Invitation


def wizard(
    context: typer.Context,
    session: Joined = None,
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
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Open the operator's panel: watch a session and control it.

    The session runs in another terminal with --operator, or on another machine with --listen. F1
    shows all keys.
    """
    home = Home.of(context, data, tasks)
    where = session_to_show(session, link, home.folder, wait=wait, observe=observe)
    name = name_at_session(name, link, observe=observe)
    need_screen()
    from sar_tui.operator.app import WizardApp, run_wizard
    from sar_tui.plugins import DEFAULT_THEME

    theme = home.catalogue().theme(DEFAULT_THEME)
    app = WizardApp(
        theme, home.folder, name, "observer" if observe else "operator", where, waits=wait
    )
    raise typer.Exit(run_wizard(app, lambda text: print(text, file=sys.stderr)))


def session_to_show(
    session: str | None, link: Path | None, data: Path, *, wait: bool, observe: bool
) -> "JoinableSession | Invitation | None":
    """Return the session of a data folder to join, or None if the user must choose one or wait.

    Raises:
        Refused: there is no such session.
        LinkError: it cannot be joined from here.
    """
    from sar_tui.cli.session_choice import session_to_join
    from sar_tui.link.discovery import joinable_sessions
    from sar_tui.link.errors import need_packages

    if link is not None:
        if session or wait:
            raise Refused("An invitation is for one session: leave out SESSION and --wait.")
        where = session_to_join(None, link, data)
        if observe and getattr(where, "role", None) == "operator":
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
    import os
    import re

    from sar_tui.link.invitation import NAME

    if name is None:
        from sar_tui.operator.app import own_name

        return f"{own_name()[:20]}-{os.getpid()}" if observe else own_name()
    if link is not None:
        raise Refused("An invitation contains your name: leave out --name.")
    if not re.fullmatch(NAME, name):
        raise Refused(f"{name!r} is not a valid name: use at most 32 letters, digits, - and _.")
    return name

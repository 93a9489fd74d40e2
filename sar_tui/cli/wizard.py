"""``sar-tui wizard``: the operator's panel of a session that runs in another terminal, or on another machine."""

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
        typer.Option(metavar="NAME", show_default=False, help="What you are called there; else your login name."),
    ] = None,
    observe: Annotated[bool, typer.Option("--observe", help="Only look.")] = False,
    wait: Annotated[bool, typer.Option("--wait", help="Wait for a session that can be joined.")] = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Watch and steer a session: the operator's panel.

    The session runs in another terminal, with --operator; or on another machine, with --listen. F1 shows all keys.
    """
    home = Home.of(context, data, tasks)
    where = session_to_show(session, link, wait=wait, observe=observe)
    called = name_there(name, link, observe=observe)
    need_screen()
    from sar_tui.operator.app import WizardApp, run_wizard
    from sar_tui.plugins import DEFAULT_THEME

    theme = home.catalogue().theme(DEFAULT_THEME)
    app = WizardApp(theme, home.folder, called, "observer" if observe else "operator", where, waits=wait)
    raise typer.Exit(run_wizard(app, lambda words: print(words, file=sys.stderr)))


def session_to_show(
    session: str | None, link: Path | None, *, wait: bool, observe: bool
) -> "JoinableSession | Invitation | None":
    """The session to join; None where there is a choice, or one is waited for.

    Raises:
        Refused: there is none such.
        LinkError: it cannot be joined from here.
    """
    from sar_tui.cli.session_choice import session_to_join
    from sar_tui.link.discovery import live_sessions
    from sar_tui.link.errors import need_packages

    if link is not None:
        if session or wait:
            raise Refused("An invitation is to one session: leave out SESSION and --wait.")
        where = session_to_join(None, link)
        if observe and getattr(where, "role", None) == "operator":
            raise Refused(f"{link} invites an operator, who can act. To only look, have an observer invited.")
        return where
    if session is None:
        need_packages()
        found = live_sessions()
        if len(found) > 1 or (wait and not found):
            return None
    return session_to_join(session, None)


def name_there(name: str | None, link: Path | None, *, observe: bool) -> str:
    """What to be called; an invitation says it itself. Of one user's observers there may be several, as in browsers."""
    import os
    import re

    from sar_tui.link.invitation import NAME

    if name is None:
        from sar_tui.operator.session_picker import own_name

        return f"{own_name()[:20]}-{os.getpid()}" if observe else own_name()
    if link is not None:
        raise Refused("An invitation says what you are called: leave out --name.")
    if not re.fullmatch(NAME, name):
        raise Refused(f"{name!r} cannot be a name here: letters, figures, - and _, at most 32.")
    return name

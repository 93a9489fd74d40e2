"""``sar-tui agent``: shows the agent alone, for a session that runs in another terminal."""

import os
import sys
from typing import TYPE_CHECKING

import typer

from sar_tui.cli.common import Data, Home, Tasks, need_screen
from sar_tui.cli.session_choice import Joined, Link

if TYPE_CHECKING:
    import asyncio

    from sar_tui.link.peer import Peer, PeerListener

_NAME = "agent"
"""Name of the view in the session's log; the process id is appended, as there can be several."""


def follow_agent(
    context: typer.Context,
    session: Joined = None,
    link: Link = None,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Show the agent alone: its face, speech and gestures.

    It follows a session that was started with --operator or --listen, and cannot act.
    """
    from sar_tui.cli.session_choice import session_to_join

    home = Home.of(context, data, tasks)
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

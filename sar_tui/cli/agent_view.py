"""``sar-tui agent``: the agent alone, beside a session that runs in another terminal."""

import os
import sys
from typing import TYPE_CHECKING

import typer

from sar_tui.cli.common import Data, Home, Tasks, need_screen
from sar_tui.cli.errors import FAILED
from sar_tui.cli.session_choice import Joined, Link

if TYPE_CHECKING:
    import asyncio

    from sar_tui.link.peer import Peer, PeerListener

_NAME = "agent"
"""What the view is called in the session's log, with a number of its own, so that there can be several."""


def follow_agent(
    context: typer.Context,
    session: Joined = None,
    link: Link = None,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Show the agent alone: its face, its words, how it moves.

    It follows a session that was begun with --operator or --listen, and only looks on.
    """
    from sar_tui.cli.session_choice import session_to_join

    catalogue = Home.of(context, data, tasks).catalogue()
    where = session_to_join(session, link)
    need_screen()
    from sar_tui.app.agent.app import AgentApp
    from sar_tui.link.client import connect
    from sar_tui.plugins import DEFAULT_THEME

    def join(hear: "PeerListener", loop: "asyncio.AbstractEventLoop") -> "Peer":
        return connect(where, f"{_NAME}-{os.getpid()}", "observer", hear, loop)

    app = AgentApp(catalogue.theme(DEFAULT_THEME), join)
    app.run()
    if app.failure:
        print(app.failure, file=sys.stderr)
    raise typer.Exit(FAILED if app.failure else app.return_code or 0)

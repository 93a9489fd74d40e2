"""A panel in a process of its own, for tests to freeze and to kill: tells each state of its link, a line each.

``python -m tests.link.panel_process SESSION LINK NAME ROLE``; a line on its standard input is sent as a note.
"""

import asyncio
import sys
from typing import get_args

from sar_tui.framework import messages as m
from sar_tui.framework.topics import NOTE_ADDED
from sar_tui.link.client import connect
from sar_tui.link.discovery import JoinableSession
from sar_tui.link.peer import Connection, PeerEvent, Welcome


async def main(session: str, link: str, name: str, role: str) -> None:
    loop = asyncio.get_running_loop()
    over = asyncio.Event()

    def hear(heard: PeerEvent) -> None:
        if isinstance(heard, Connection):
            print(heard.state, flush=True)
            if heard.state == "ended":
                over.set()
        elif isinstance(heard, Welcome):
            print("welcome", flush=True)

    where = JoinableSession(session=session, task="keyboard", link=link, pid=0)
    (known,) = (each for each in get_args(m.Role) if each == role)
    peer = connect(where, name, known, hear, loop)

    def told() -> None:
        line = sys.stdin.readline().strip()
        if not line:
            over.set()
        peer.send(NOTE_ADDED, m.NoteAdded(text=line))

    loop.add_reader(sys.stdin.fileno(), told)
    await over.wait()
    peer.close()


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))

"""Operator's panel in a process of its own that tests can freeze and kill. It prints each state of its link.

``python -m tests.link.panel_process SESSION LINK NAME``; each line on standard input is sent
as a note.
"""

import asyncio
import sys

from sar_tui.link.client import connect
from sar_tui.link.discovery import JoinableSession
from sar_tui.link.peer import Connection, PeerEvent, Welcome
from sar_tui.loop.topics import NOTE_ADDED
from sar_tui.model import messages as m


async def main(session: str, link: str, name: str) -> None:
    loop = asyncio.get_running_loop()
    over = asyncio.Event()

    def receive(event: PeerEvent) -> None:
        if isinstance(event, Connection):
            print(event.state, flush=True)
            if event.state == "ended":
                over.set()
        elif isinstance(event, Welcome):
            print("welcome", flush=True)

    where = JoinableSession(session=session, task="keyboard", link=link, pid=0)
    peer = connect(where, name, "operator", receive, loop)

    def send_note() -> None:
        line = sys.stdin.readline().strip()
        if not line:
            over.set()
        peer.send(NOTE_ADDED, m.NoteAdded(text=line))

    loop.add_reader(sys.stdin.fileno(), send_note)
    await over.wait()
    peer.close()


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))

"""Opens the link of a session: where it was asked to listen, and nowhere else."""

import contextlib
import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from sar_tui.framework.clock import MS
from sar_tui.link.authority import Authority
from sar_tui.link.broker_process import BrokerProcess
from sar_tui.link.discovery import JoinableSession, announce
from sar_tui.link.errors import LinkError, need_packages
from sar_tui.link.protocol import Setup
from sar_tui.link.settings import Endpoint, TlsFiles, host_settings, parse_endpoint

_WHY = (
    ("Address already in use", "Another program listens there already. Choose another port, such as {host}:7448."),
    ("Permission denied", "That port is not for everybody. Choose one above 1023."),
    ("Cannot assign requested address", "This computer has no such address."),
    ("failed to lookup address", "This computer has no such address."),
)
"""What the system says, and what to tell of it."""


class ListenOptions(NamedTuple):
    """Where a session listens: for ``operator`` programs of the same user, and at an ``end`` on the network."""

    operator: bool
    end: Endpoint | None

    @classmethod
    def parse(cls, *, operator: bool, listen: str | None) -> "ListenOptions":
        """As it was asked for. Raises LinkError where ``listen`` is no place."""
        return cls(operator, None if listen is None else parse_endpoint(listen))


@contextlib.contextmanager
def open_link(data: Path, session: str, task: str, listening: ListenOptions, lost_ms: int) -> Iterator[BrokerProcess]:
    """The link of a session for as long as the block runs.

    Args:
        data: the data folder, whose authority vouches for whoever comes over the network.
        session, task: what it is, for operators on this machine to find it.
        listening: where. A socket is in a folder of this user's alone; the network takes certificates.
        lost_ms: an operator who was silent for so long is lost.

    Raises:
        LinkError: it cannot be opened as asked.
    """
    need_packages()
    ends: tuple[Endpoint, ...] = (listening.end,) if listening.end else ()
    files: TlsFiles | None = None
    authority = None
    link = session
    if ends:
        authority = Authority.open(data)
        files = authority.host_files(ends)
        link = authority.link
    guests = authority.guests() if authority else ()
    with contextlib.ExitStack() as stack:
        socket = None
        if listening.operator:
            socket = stack.enter_context(
                announce(JoinableSession(session=session, task=task, link=link, pid=os.getpid()))
            )
        settings = host_settings(link, socket=socket, listen=ends, files=files, guests=guests)
        names = tuple(str(guest) for guest in guests) if authority else None
        host = BrokerProcess(Setup(settings, link, lost_ms * MS, names))
        try:
            host.open()
        except LinkError as error:
            raise LinkError(_words(str(error), ends)) from error
        stack.callback(host.close)
        yield host


def _words(why: str, ends: Sequence[Endpoint]) -> str:
    """Why it cannot listen, from what Zenoh says."""
    if ends:
        for part, words in _WHY:
            if re.search(part, why, re.IGNORECASE):
                return f"The session cannot listen on {ends[0]}. {words.format(host=ends[0].host)}"
    return f"The link cannot be opened. {why}"

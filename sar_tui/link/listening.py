"""Opens the link of a session on a Unix socket, on the network, or both."""

import contextlib
import os
import re
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from sar_tui.link.authority import Authority
from sar_tui.link.broker_process import BrokerProcess
from sar_tui.link.discovery import JoinableSession, announce, folder_name
from sar_tui.link.errors import LinkError, need_packages
from sar_tui.link.protocol import Setup
from sar_tui.link.zenoh_settings import Endpoint, TlsFiles, host_settings, parse_endpoint
from sar_tui.model.units import MS

_EXPLANATIONS = (
    (
        "Address already in use",
        "Another program listens there already. Choose another port, such as {host}:7448.",
    ),
    ("Permission denied", "That port is reserved. Choose one above 1023."),
    ("Cannot assign requested address", "This computer has no such address."),
    ("failed to lookup address", "This computer has no such address."),
)
"""The system's errors, and their explanations."""


class ListenOptions(NamedTuple):
    """Addresses to listen on: a Unix socket if ``operator``, and a network ``end``."""

    operator: bool
    end: Endpoint | None

    @classmethod
    def parse(cls, *, operator: bool, listen: str | None) -> "ListenOptions":
        """Parse the options of the command line. Raises LinkError if ``listen`` is not an
        address.
        """
        return cls(operator, None if listen is None else parse_endpoint(listen))


@contextlib.contextmanager
def open_link(
    data: Path,
    session: str,
    task: str,
    participants: Sequence[str],
    listening: ListenOptions,
    lost_ms: int,
) -> Iterator[BrokerProcess]:
    """Open the link of a session for the duration of the block.

    Args:
        data: the data folder, whose certificate authority admits guests over the network, and whose
            operators find the session on this machine.
        session, task, participants: shown to operators on this machine.
        listening: where to listen. The socket's folder is private to this user; the network
            requires certificates.
        lost_ms: silence after which an operator is lost (ms).

    Raises:
        LinkError: the link cannot be opened as asked.
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
    guests = [guest for guest in (authority.guests() if authority else ()) if guest.role != "home"]
    with contextlib.ExitStack() as stack:
        socket = None
        if listening.operator:
            live = JoinableSession(
                session=session,
                task=task,
                link=link,
                pid=os.getpid(),
                data=folder_name(data),
                participants=tuple(participants),
                started=datetime.now(UTC).isoformat(timespec="seconds"),
            )
            socket = stack.enter_context(announce(live))
        settings = host_settings(link, socket=socket, listen=ends, files=files, guests=guests)
        names = tuple(str(guest) for guest in guests) if authority else None
        broker = BrokerProcess(Setup(settings, link, lost_ms * MS, names))
        try:
            broker.open()
        except LinkError as error:
            raise LinkError(why_not_listening(str(error), ends)) from error
        stack.callback(broker.close)
        yield broker


def why_not_listening(error: str, ends: Sequence[Endpoint], what: str = "The session") -> str:
    """Return why the session, or something else, cannot listen, from Zenoh's error."""
    if ends:
        for part, explanation in _EXPLANATIONS:
            if re.search(part, error, re.IGNORECASE):
                return f"{what} cannot listen on {ends[0]}. {explanation.format(host=ends[0].host)}"
    return f"The link cannot be opened. {error}"

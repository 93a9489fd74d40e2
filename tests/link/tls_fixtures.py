"""Certificate authority, host and guests for tests: real Zenoh sessions with TLS over loopback."""

import socket
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import NamedTuple

import msgspec
import zenoh

from sar_tui.link.authority import Authority
from sar_tui.link.invitation import Invitation
from sar_tui.link.zenoh_settings import (
    Endpoint,
    Guest,
    LinkKeys,
    config,
    host_settings,
    network_settings,
)

NOW = datetime.now(UTC)
LONG_AGO = NOW - timedelta(days=40)


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def eventually(true: Callable[[], object], seconds: float = 60) -> bool:
    """Wait until a condition holds; return False after ``seconds``."""
    deadline = time.monotonic() + seconds
    while not true():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.005)
    return True


class LinkGuests(NamedTuple):
    """Authority, its endpoint, and its invitations."""

    authority: Authority
    where: Endpoint
    anna: Invitation
    ben: Invitation
    eve: Invitation
    gone: Invitation
    late: Invitation

    @property
    def keys(self) -> LinkKeys:
        return LinkKeys(self.authority.link)


def invite_guests(data: Path) -> LinkGuests:
    """Invite operators Anna and Ben, observer Eve, the revoked Gone and the expired Late."""
    where = Endpoint("127.0.0.1", free_port())
    authority = Authority.open_or_create(data)
    made = LinkGuests(
        authority,
        where,
        authority.invite(Guest("anna", "operator"), [where], 30),
        authority.invite(Guest("ben", "operator"), [where], 30),
        authority.invite(Guest("eve", "observer"), [where], 30),
        authority.invite(Guest("gone", "operator"), [where], 30),
        authority.invite(Guest("late", "operator"), [where], 30, LONG_AGO),
    )
    authority.revoke("gone")
    return made


class FakeBroker:
    """Host's Zenoh session that records messages as ``(key, payload)``, queries, and changes of
    liveliness.
    """

    def __init__(self, session: zenoh.Session, keys: LinkKeys) -> None:
        self.session = session
        self.received: list[tuple[str, bytes]] = []
        self.queries: list[str] = []
        self.liveliness: list[str] = []
        self._held = (
            session.declare_subscriber(
                "**", lambda s: self.received.append((str(s.key_expr), bytes(s.payload)))
            ),
            session.declare_queryable("**", lambda q: self.queries.append(str(q.key_expr))),
            session.liveliness().declare_subscriber(
                keys.ping("*"), lambda s: self.liveliness.append(str(s.key_expr))
            ),
        )


def without_certificate(invited: Invitation) -> str:
    """Return a guest's settings without their certificate."""
    settings = msgspec.json.decode(network_settings(invited.where[0], invited.credentials))
    for name in ("connect_certificate_base64", "connect_private_key_base64", "enable_mtls"):
        del settings["transport"]["link"]["tls"][name]
    return msgspec.json.encode(settings).decode()


@contextmanager
def hosting(at: LinkGuests) -> Iterator[FakeBroker]:
    """Run the host as a session with ``--listen`` does."""
    files = at.authority.host_files([at.where])
    settings = host_settings(
        at.authority.link, listen=[at.where], files=files, guests=at.authority.guests()
    )
    with zenoh.open(config(settings)) as session:
        yield FakeBroker(session, at.keys)


@contextmanager
def visiting(*invitations: Invitation) -> Iterator[list[zenoh.Session]]:
    """Open Zenoh sessions of guests. Raises zenoh.ZError if one is rejected."""
    with ExitStack() as stack:
        yield [
            stack.enter_context(
                zenoh.open(config(network_settings(invited.where[0], invited.credentials)))
            )
            for invited in invitations
        ]

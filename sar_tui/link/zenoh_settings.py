"""Zenoh's settings: where a session listens, whom it admits, and what each peer may send and
receive.

A host listens only at the given addresses and searches for nobody; a peer does not listen.
Everything that is not explicitly allowed is denied, in both directions: Zenoh drops it in the
host's network thread, before our code sees it.
"""

import base64
import ipaddress
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import msgspec

from sar_tui.link.errors import LinkError, no_packages

if TYPE_CHECKING:
    import zenoh

InvitedAs = Literal["operator", "observer", "home"]
"""A role at a session; or ``home``: the participant's computer, which dials out to a router."""
PORT = 7447
"""Default port, the one registered for Zenoh."""
LEASE_MS = 1000
"""Silence after which Zenoh drops a connection, to open a new one. It does not decide that an
operator is lost.
"""
VISIT_LEASE_MS = 5000
"""The same over a router, where a packet may take long."""
RETRY_MS = (250, 1000)
"""Shortest and longest delay before a peer reconnects; it doubles each time."""
MAX_MESSAGE_BYTES = 4 * 2**20
"""Zenoh's default is 1 GiB."""
MAX_SESSIONS = 64

_KEY_PART = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")
"""One part of a key, without Zenoh's separator and wildcards."""
_HOST = re.compile(r"[A-Za-z0-9]([A-Za-z0-9.-]*[A-Za-z0-9])?")


class Guest(NamedTuple):
    """Invited operator or observer, or home."""

    name: str
    role: InvitedAs

    def __str__(self) -> str:
        """Return the name used in keys and as the certificate's common name: ``operator.op1``."""
        return f"{self.role}.{self.name}"


class LinkKeys(NamedTuple):
    """Zenoh key expressions of a link.

    ``link``: its id; through a router, that of the clinic and the name of a home, or ``*`` for all
    homes: see `home_link`.
    """

    link: str

    @property
    def all(self) -> str:
        """All keys of the link."""
        return f"sar-tui/{self.link}/**"

    @property
    def broadcast(self) -> str:
        """From the session to all peers."""
        return f"sar-tui/{self.link}/out"

    def act(self, peer: str) -> str:
        """From an operator to the session. ``*``: any operator."""
        return f"sar-tui/{self.link}/act/{peer}"

    def ping(self, peer: str) -> str:
        """Heartbeats and clock pings from a peer to the session. ``*``: any peer."""
        return f"sar-tui/{self.link}/hello/{peer}"

    def reply(self, peer: str) -> str:
        """From the session to one peer."""
        return f"sar-tui/{self.link}/back/{peer}"


def home_link(link: str, home: str) -> str:
    """Return the id of the link of a home, through the router of the clinic whose link this is."""
    return f"{link}/{home}"


class Endpoint(NamedTuple):
    """Host name or address, and port."""

    host: str
    port: int

    def __str__(self) -> str:
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    @property
    def locator(self) -> str:
        """The endpoint as a Zenoh locator."""
        return f"tls/{self}"


class TlsFiles(NamedTuple):
    """Paths of a host's certificate and key, and of the certificate of the authority that it
    trusts.
    """

    authority: Path
    certificate: Path
    key: Path


class Credentials(msgspec.Struct, frozen=True):
    """Certificate and key of a peer, and the certificate of the authority that it trusts; all
    PEM.
    """

    authority: str
    certificate: str
    key: str

    def __repr__(self) -> str:
        return "Credentials(…)"


def parse_endpoint(text: str) -> Endpoint:
    """Parse ``HOST``, ``HOST:PORT``, an address, or ``[IPv6]:PORT``, with or without a leading
    ``tls/``.

    Raises LinkError.
    """
    plain = text.strip().removeprefix("tls/")
    example = (
        "Give a name or an address, and a port if it is not 7447: lab-pc.local or "
        "192.168.1.20:7447."
    )
    if plain.startswith("["):
        host, closed, rest = plain[1:].partition("]")
        if not closed or (rest and not rest.startswith(":")):
            raise LinkError(f"{text} is not a network address. {example}")
        port = rest[1:] if rest else str(PORT)
    elif plain.count(":") > 1:
        host, port = plain, str(PORT)
    else:
        host, colon, port = plain.partition(":")
        port = port if colon else str(PORT)
    if not (port.isascii() and port.isdigit() and 1 <= int(port) <= 65535):
        raise LinkError(f"{text} has no valid port, which is a number from 1 to 65535. {example}")
    if not (_is_address(host) or (_HOST.fullmatch(host) and len(host) <= 253)):
        raise LinkError(f"{text} is not a network address. {example}")
    return Endpoint(host, int(port))


def _is_address(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return "%" not in host


def host_settings(
    link: str,
    *,
    socket: Path | None = None,
    listen: Sequence[Endpoint] = (),
    files: TlsFiles | None = None,
    guests: Iterable[Guest] = (),
) -> str:
    """Return a session's settings as JSON: it listens on a Unix socket, on the network, on both, or
    nowhere.

    The session is a router in Zenoh's terms, so that peers talk to it alone. The JSON contains
    paths but no private key, so that no message of Zenoh's can reveal one.

    Args:
        files: needed to listen on the network; a peer without a certificate of that authority is
            rejected.
        guests: those admitted over the network. On the Unix socket, in a folder that only this user
            can enter, everything is allowed.
    """
    locators = [end.locator for end in listen]
    if socket is not None:
        locators.append(f"unixsock-stream/{socket}")
    settings = _common("router")
    settings["listen"] = {"endpoints": locators, "exit_on_failure": True}
    settings["transport"]["unicast"] = {"max_sessions": MAX_SESSIONS}
    settings["access_control"] = _access(LinkKeys(_key_part(link)), list(guests))
    if listen:
        if files is None:
            raise ValueError("listening on the network needs certificates")
        settings["transport"]["link"]["tls"] = _listening(files)
    return msgspec.json.encode(settings).decode()


def router_settings(
    link: str, listen: Sequence[Endpoint], files: TlsFiles, guests: Iterable[Guest]
) -> dict[str, Any]:
    """Return the settings of the clinic's router, for zenoh and for ``zenohd``.

    A home reaches its own keys only. An operator or observer reaches what is for them among the
    keys of each home, and acts under their own name.

    Args:
        link: the id of the clinic's link.
        listen: where the router listens, with TLS.
        files: its certificate; whoever has none of that authority is rejected.
        guests: homes, operators and observers.
    """
    settings = _common("router", VISIT_LEASE_MS)
    settings["listen"] = {"endpoints": [end.locator for end in listen], "exit_on_failure": True}
    settings["transport"]["link"]["protocols"] = ["tls"]
    settings["transport"]["link"]["tls"] = _listening(files)
    access = _Access()
    for guest in guests:
        if guest.role == "home":
            _let_home_in(access, LinkKeys(home_link(_key_part(link), _key_part(guest.name))), guest)
        else:
            _let_visitor_in(access, LinkKeys(home_link(_key_part(link), "*")), guest)
    settings["access_control"] = access.settings
    return settings


def _listening(files: TlsFiles) -> dict[str, Any]:
    return {
        "enable_mtls": True,
        "root_ca_certificate": str(files.authority),
        "listen_certificate": str(files.certificate),
        "listen_private_key": str(files.key),
        "close_link_on_expiration": True,
    }


def socket_settings(socket: Path) -> str:
    """Return the settings of a peer on the same machine, as JSON."""
    return _client(f"unixsock-stream/{socket}", {})


def network_settings(
    where: Endpoint, credentials: Credentials, *, through_router: bool = False
) -> str:
    """Return the settings of a peer on another machine, or of a home, as JSON. They contain its
    private key: keep them out of logs.

    The host's certificate must be issued by our authority for a host and name the host that was
    asked for, so that no other peer can pose as the host.
    """
    return _client(
        where.locator,
        {
            "enable_mtls": True,
            "verify_name_on_connect": True,
            "root_ca_certificate_base64": _base64(credentials.authority),
            "connect_certificate_base64": _base64(credentials.certificate),
            "connect_private_key_base64": _base64(credentials.key),
            "close_link_on_expiration": True,
        },
        VISIT_LEASE_MS if through_router else LEASE_MS,
    )


def config(settings: str) -> "zenoh.Config":
    """Return the settings as a Zenoh configuration. Raises LinkError if Zenoh is not installed."""
    try:
        import zenoh
    except ImportError:
        raise LinkError(no_packages()) from None
    return zenoh.Config.from_json5(settings)


def _client(locator: str, tls: dict[str, Any], lease_ms: int = LEASE_MS) -> str:
    """Return settings that fail at once if the first attempt does, but reconnect for ever after
    that.
    """
    settings = _common("client", lease_ms)
    first, longest = RETRY_MS
    settings["connect"] = {
        "endpoints": [locator],
        "timeout_ms": 0,
        "exit_on_failure": True,
        "retry": {"period_init_ms": first, "period_max_ms": longest, "period_increase_factor": 2},
    }
    if tls:
        settings["transport"]["link"]["tls"] = tls
    return msgspec.json.encode(settings).decode()


def _common(mode: str, lease_ms: int = LEASE_MS) -> dict[str, Any]:
    return {
        "mode": mode,
        "listen": {"endpoints": []},
        "connect": {"endpoints": []},
        "scouting": {"delay": 0, "multicast": {"enabled": False}, "gossip": {"enabled": False}},
        "open": {"return_conditions": {"connect_scouted": False, "declares": False}},
        "adminspace": {"enabled": False},
        "plugins_loading": {"enabled": False},
        "timestamping": {"enabled": False},
        "transport": {
            "link": {
                "protocols": ["tls", "unixsock-stream"],
                "tx": {"lease": lease_ms, "keep_alive": 4},
                "rx": {"max_message_size": MAX_MESSAGE_BYTES},
            },
            "shared_memory": {"enabled": False},
        },
    }


_PUBLISH = ["put"]
_SUBSCRIBE = ["declare_subscriber"]
_ANNOUNCE = ["liveliness_token"]
_WATCH = ["declare_liveliness_subscriber", "liveliness_query"]
_IN, _OUT = ["ingress"], ["egress"]


class _Access:
    """Zenoh's access control: rules, and who they are for. What no rule allows is denied."""

    def __init__(self) -> None:
        self.settings: dict[str, Any] = {
            "enabled": True,
            "default_permission": "deny",
            "rules": [],
            "subjects": [],
            "policies": [],
        }
        self._known: set[str] = set()

    def allow(self, rule: str, messages: list[str], flows: list[str], where: list[str]) -> str:
        """Add a rule, unless there is one of this name; return its name."""
        if rule not in self._known:
            self._known.add(rule)
            made = {"messages": messages, "flows": flows, "key_exprs": where}
            self.settings["rules"].append({"id": rule, "permission": "allow", **made})
        return rule

    def grant(self, subject: dict[str, Any], rules: list[str]) -> None:
        """Let rules apply to somebody."""
        self.settings["subjects"].append(subject)
        self.settings["policies"].append({"rules": rules, "subjects": [subject["id"]]})

    def grant_guest(self, name: str, rules: list[str]) -> None:
        """Let rules apply to whoever has a certificate of this name."""
        self.grant({"id": name, "cert_common_names": [name], "link_protocols": ["tls"]}, rules)


def _let_home_in(access: _Access, keys: LinkKeys, home: Guest) -> None:
    """Let a home announce its session, and reach those who visit it, each by a key of their own."""
    name = _key_part(str(home))
    visitors = [keys.act("*"), keys.ping("*")]
    access.grant_guest(
        name,
        [
            access.allow(f"{name} announces itself", _ANNOUNCE, _IN, [keys.broadcast]),
            access.allow(f"{name} listens", _SUBSCRIBE, _IN, visitors),
            access.allow(f"{name} watches for visitors", _WATCH, _IN, [keys.ping("*")]),
            access.allow(f"{name} receives", _PUBLISH, _OUT, visitors),
            access.allow(f"{name} sees visitors", _ANNOUNCE, _OUT, [keys.ping("*")]),
            access.allow(f"{name} sends", _PUBLISH, _IN, [keys.reply("*")]),
            access.allow(f"{name} sees who listens", _SUBSCRIBE, _OUT, [keys.reply("*")]),
            access.allow(f"{name} checks itself", _ANNOUNCE, _IN, [keys.ping(name)]),
        ],
    )


def _let_visitor_in(access: _Access, keys: LinkKeys, guest: Guest) -> None:
    """Let an operator or observer see which homes are there, and visit each under their own
    name.
    """
    name = _key_part(str(guest))
    own = [keys.act(name), keys.ping(name)]
    homes = [keys.broadcast]
    access.grant_guest(
        name,
        [
            access.allow("visitors watch for homes", _WATCH, _IN, homes),
            access.allow("visitors see homes", _ANNOUNCE, _OUT, homes),
            access.allow(f"{name} sends", _PUBLISH, _IN, own),
            access.allow(f"{name} sees who listens", _SUBSCRIBE, _OUT, own),
            access.allow(f"{name} listens", _SUBSCRIBE, _IN, [keys.reply(name)]),
            access.allow(f"{name} receives", _PUBLISH, _OUT, [keys.reply(name)]),
            access.allow(f"{name} announces itself", _ANNOUNCE, _IN, [keys.ping(name)]),
            access.allow(f"{name} checks itself", _WATCH, _IN, [keys.ping(name)]),
            access.allow(f"{name} sees itself", _ANNOUNCE, _OUT, [keys.ping(name)]),
        ],
    )


def _access(keys: LinkKeys, guests: list[Guest]) -> dict[str, Any]:
    """Return Zenoh's access control. Everything that no rule allows is denied: deletions, queries,
    others' acts.

    Everyone has acts, as everyone may stop the agent; `admission` refuses the other acts of
    observers.

    A key expression must lie completely within a rule's keys: a wildcard that reaches further is
    denied.
    """
    access = _Access()
    allow = access.allow
    both = _IN + _OUT
    access.grant(
        {"id": "same user", "link_protocols": ["unixsock-stream"]},
        [allow("same user", _PUBLISH + _SUBSCRIBE + _ANNOUNCE + _WATCH, both, [keys.all])],
    )
    shared = [
        allow("the session subscribes", _SUBSCRIBE + _WATCH, _OUT, [keys.act("*"), keys.ping("*")]),
        allow("guests watch the session", _WATCH, _IN, [keys.broadcast]),
        allow("the session announces itself", _ANNOUNCE, _OUT, [keys.broadcast]),
    ]
    for guest in guests:
        _key_part(guest.name)
        name = _key_part(str(guest))
        sends = [keys.ping(name), keys.act(name)]
        receives = [keys.broadcast, keys.reply(name)]
        access.grant_guest(
            name,
            [
                *shared,
                allow(f"{name} sends", _PUBLISH, _IN, sends),
                allow(f"{name} subscribes", _SUBSCRIBE, _IN, receives),
                allow(f"{name} receives", _PUBLISH, _OUT, receives),
                allow(f"{name} announces itself", _ANNOUNCE, _IN, [keys.ping(name)]),
            ],
        )
    return access.settings


def _key_part(text: str) -> str:
    if not _KEY_PART.fullmatch(text):
        raise ValueError(f"{text!r} cannot be part of a key")
    return text


def _base64(text: str) -> str:
    return base64.b64encode(text.encode()).decode()

"""Zenoh's settings: where a session listens, whom it lets in, and what each may send and hear.

A host listens exactly where it is told to and looks for nobody; a peer listens nowhere. Everything that is not allowed
by name is denied, in both directions: zenoh drops it in the host's network thread, before any of our code sees it.
"""

import base64
import ipaddress
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec

from sar_tui.framework.messages import Role
from sar_tui.link.errors import NO_PACKAGES, LinkError

if TYPE_CHECKING:
    import zenoh

PORT = 7447
"""Where a session listens unless told otherwise: the port that is registered for zenoh."""
LEASE_MS = 1000
"""A peer that has not been heard for so long is gone: frozen, or cut off."""
RETRY_MS = (250, 1000)
"""A peer that lost its host knocks again after the first, then ever more slowly, down to once in the second."""
LONGEST_MESSAGE = 4 * 2**20
"""Bytes; zenoh would put together a message of 1 GiB for whoever sends one."""
MOST_SESSIONS = 64

_CHUNK = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")
"""One part of a key: nothing in it is a separator or a wildcard to zenoh."""
_HOST = re.compile(r"[A-Za-z0-9]([A-Za-z0-9.-]*[A-Za-z0-9])?")


class Guest(NamedTuple):
    """Somebody outside of the session's own program, as a host knows them."""

    name: str
    role: Role

    def __str__(self) -> str:
        """As in keys, and as the common name of the certificate: ``operator.anna``."""
        return f"{self.role}.{self.name}"


class LinkKeys(NamedTuple):
    """Where each message of a link goes."""

    link: str

    @property
    def everything(self) -> str:
        return f"sar-tui/{self.link}/**"

    @property
    def out(self) -> str:
        """From the session to everybody."""
        return f"sar-tui/{self.link}/out"

    def act(self, peer: str) -> str:
        """What an operator does. ``*``: any of them."""
        return f"sar-tui/{self.link}/act/{peer}"

    def hello(self, peer: str) -> str:
        """Signs of life, and clock pings. ``*``: anybody's."""
        return f"sar-tui/{self.link}/hello/{peer}"

    def back(self, peer: str) -> str:
        """From the session to one peer."""
        return f"sar-tui/{self.link}/back/{peer}"


class Endpoint(NamedTuple):
    """A host's name or address, and its port."""

    host: str
    port: int

    def __str__(self) -> str:
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    @property
    def locator(self) -> str:
        """As zenoh writes it."""
        return f"tls/{self}"


class TlsFiles(NamedTuple):
    """Where a host's certificate and key lie, and the certificate of the authority that it trusts."""

    authority: Path
    certificate: Path
    key: Path


class Credentials(msgspec.Struct, frozen=True):
    """A peer's own certificate and key, and the certificate of the authority that it trusts; all PEM."""

    authority: str
    certificate: str
    key: str

    def __repr__(self) -> str:
        return "Credentials(…)"


def parse_endpoint(text: str) -> Endpoint:
    """Read ``HOST``, ``HOST:PORT``, an address, or ``[IPv6]:PORT``, with or without ``tls/`` before it.

    Raises LinkError.
    """
    plain = text.strip().removeprefix("tls/")
    example = "Give a name or an address, and a port if it is not 7447: lab-pc.local or 192.168.1.20:7447."
    if plain.startswith("["):
        host, closed, rest = plain[1:].partition("]")
        if not closed or (rest and not rest.startswith(":")):
            raise LinkError(f"{text} is not a place on the network. {example}")
        port = rest[1:] if rest else str(PORT)
    elif plain.count(":") > 1:
        host, port = plain, str(PORT)
    else:
        host, colon, port = plain.partition(":")
        port = port if colon else str(PORT)
    if not (port.isascii() and port.isdigit() and 1 <= int(port) <= 65535):
        raise LinkError(f"{text} has no port that there could be: it is a number from 1 to 65535. {example}")
    if not (_is_address(host) or (_HOST.fullmatch(host) and len(host) <= 253)):
        raise LinkError(f"{text} is not a place on the network. {example}")
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
    """A session's side, as JSON: it listens on a Unix socket, on the network, on both, or (nothing given) nowhere.

    A router, as zenoh calls it: peers talk to it and to nobody else. To be a peer itself would bring zenoh's machinery
    for peers that find each other, and nothing here.

    The JSON holds paths and no key, so that no message of zenoh's can tell one.

    Args:
        files: needed to listen on the network; a peer without a certificate of that authority is not let in.
        guests: who may say and hear anything on the network. On the Unix socket, whose folder only this user can
            enter, all of the link is open.
    """
    locators = [end.locator for end in listen]
    if socket is not None:
        locators.append(f"unixsock-stream/{socket}")
    settings = _common("router")
    settings["listen"] = {"endpoints": locators, "exit_on_failure": True}
    settings["transport"]["unicast"] = {"max_sessions": MOST_SESSIONS}
    settings["access_control"] = _access(LinkKeys(_chunk(link)), list(guests))
    if listen:
        if files is None:
            raise ValueError("to listen on the network takes certificates")
        settings["transport"]["link"]["tls"] = {
            "enable_mtls": True,
            "root_ca_certificate": str(files.authority),
            "listen_certificate": str(files.certificate),
            "listen_private_key": str(files.key),
            "close_link_on_expiration": True,
        }
    return msgspec.json.encode(settings).decode()


def socket_settings(socket: Path) -> str:
    """A peer's side on the same machine, as JSON."""
    return _client(f"unixsock-stream/{socket}", {})


def network_settings(where: Endpoint, credentials: Credentials) -> str:
    """A peer's side on another machine, as JSON. It holds the peer's key: keep it in memory, and out of logs.

    The host's certificate has to be of our authority, made for a host (the authority makes no second kind that could
    pass for one), and has to name the host that was asked for: whoever has a peer's certificate cannot play the host.
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
    )


def config(settings: str) -> "zenoh.Config":
    """The settings, as zenoh takes them. Raises LinkError: zenoh is not installed."""
    try:
        import zenoh
    except ImportError:
        raise LinkError(NO_PACKAGES) from None
    return zenoh.Config.from_json5(settings)


def _client(locator: str, tls: dict[str, Any]) -> str:
    """The first attempt is made once and fails at once, to be told; a link that was there once is sought for ever."""
    settings = _common("client")
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


def _common(mode: str) -> dict[str, Any]:
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
                "tx": {"lease": LEASE_MS, "keep_alive": 4},
                "rx": {"max_message_size": LONGEST_MESSAGE},
            },
            "shared_memory": {"enabled": False},
        },
    }


_SEND = ["put"]
_HEAR = ["declare_subscriber"]
_BE_THERE = ["liveliness_token"]
_WATCH = ["declare_liveliness_subscriber", "liveliness_query"]
_IN, _OUT = ["ingress"], ["egress"]


def _access(keys: LinkKeys, guests: list[Guest]) -> dict[str, Any]:
    """Who may do what. What stands in no rule is denied: delete, queries and replies for all, acts for an observer.

    A rule allows what lies within its keys as a whole: to send to, or listen on, a wildcard that reaches any further is
    denied.
    """
    rules: list[dict[str, Any]] = []
    subjects: list[dict[str, Any]] = []
    policies: list[dict[str, Any]] = []

    def allow(rule: str, messages: list[str], flows: list[str], where: list[str]) -> str:
        rules.append({"id": rule, "permission": "allow", "messages": messages, "flows": flows, "key_exprs": where})
        return rule

    def policy(subject: dict[str, Any], allowed: list[str]) -> None:
        subjects.append(subject)
        policies.append({"rules": allowed, "subjects": [subject["id"]]})

    both = _IN + _OUT
    policy(
        {"id": "same user", "link_protocols": ["unixsock-stream"]},
        [allow("same user", _SEND + _HEAR + _BE_THERE + _WATCH, both, [keys.everything])],
    )
    told = [
        allow("what the session hears is no secret", _HEAR + _WATCH, _OUT, [keys.act("*"), keys.hello("*")]),
        allow("the session is there", _WATCH, _IN, [keys.out]),
        allow("the session says so", _BE_THERE, _OUT, [keys.out]),
    ]
    for guest in guests:
        _chunk(guest.name)
        name = _chunk(str(guest))
        sends = [keys.hello(name), *([keys.act(name)] if guest.role == "operator" else [])]
        hears = [keys.out, keys.back(name)]
        policy(
            {"id": name, "cert_common_names": [name], "link_protocols": ["tls"]},
            [
                *told,
                allow(f"{name} sends", _SEND, _IN, sends),
                allow(f"{name} asks to hear", _HEAR, _IN, hears),
                allow(f"{name} hears", _SEND, _OUT, hears),
                allow(f"{name} is there", _BE_THERE, _IN, [keys.hello(name)]),
            ],
        )
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": subjects,
        "policies": policies,
    }


def _chunk(text: str) -> str:
    if not _CHUNK.fullmatch(text):
        raise ValueError(f"{text!r} cannot be a part of a key")
    return text


def _base64(text: str) -> str:
    return base64.b64encode(text.encode()).decode()

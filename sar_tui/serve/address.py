"""Address that views are served at, and the host names and origins it accepts."""

import socket
from ipaddress import ip_address
from typing import NamedTuple
from urllib.parse import urlsplit

import msgspec

_PORTS = {"http": 80, "https": 443}


class AddressError(ValueError):
    """Views cannot be served at an address; the message is one clear sentence."""


class Address(msgspec.Struct, frozen=True):
    """Host and port, and the public URL if there is a tunnel or proxy.

    Raises:
        AddressError: the public URL is invalid.
    """

    host: str
    port: int
    public_url: str = ""

    def __post_init__(self) -> None:
        if self.public_url and _origin(self.public_url) is None:
            raise AddressError(
                f"{self.public_url} is not a valid public URL. It consists of http or https, a "
                "host and optionally a port: https://lab.example:8443."
            )

    @property
    def is_loopback(self) -> bool:
        """True if only this machine can reach it."""
        return _is_loopback(self.host)

    @property
    def is_encrypted(self) -> bool:
        """True if the public URL is HTTPS."""
        return self.public_url.lower().startswith("https:")

    @property
    def url(self) -> str:
        """URL to open, without the token."""
        if self.public_url:
            return self.public_url.rstrip("/") + "/"
        host = _reachable(self.host)
        host = f"[{host}]" if ":" in host else host
        return f"http://{host}:{self.port}/"

    def allows_host(self, host: str) -> bool:
        """Return whether a request's ``Host`` is accepted.

        Another site can point its own name to this machine (DNS rebinding), so only IP addresses,
        ``localhost`` and the configured names are accepted.
        """
        requested = _origin(f"http://{host}")
        if requested is None:
            return False
        _, name, port = requested
        if self.public_url and (public := _origin(self.public_url)):
            at_public_scheme = _origin(f"{public.scheme}://{host}")
            if at_public_scheme == public:
                return True
        if port != self.port:
            return False
        if self.is_loopback:
            return _is_loopback(name)
        return name in ("localhost", self.host.lower()) or _is_ip_address(name)

    def allows_origin(self, origin: str, host: str) -> bool:
        """Return whether an ``Origin`` is that of a page served here under ``host``, which must be
        accepted itself.
        """
        page = _origin(origin)
        return page is not None and page in (_origin(f"http://{host}"), _origin(self.public_url))


def _reachable(host: str) -> str:
    """Return a host that others can open: for a wildcard address, this machine's address on its
    default route.
    """
    if not (_is_ip_address(host) and ip_address(host).is_unspecified):
        return host
    family, elsewhere = (
        (socket.AF_INET6, "2001:db8::1") if ":" in host else (socket.AF_INET, "192.0.2.1")
    )
    try:
        with socket.socket(family, socket.SOCK_DGRAM) as probe:
            probe.connect((elsewhere, 9))  # sends nothing: it only finds the route
            return str(probe.getsockname()[0])
    except OSError:  # no network: only this machine can open it
        return "::1" if ":" in host else "127.0.0.1"


class _Origin(NamedTuple):
    scheme: str
    name: str
    port: int


def _origin(url: str) -> _Origin | None:
    """Parse an origin, with the default port filled in; None if it is invalid."""
    try:
        parts = urlsplit(url)
        port = parts.port
    except ValueError:
        return None
    if parts.scheme not in _PORTS or not parts.hostname or port == 0 or "@" in parts.netloc:
        return None
    if parts.path not in ("", "/") or parts.query or parts.fragment:
        return None
    return _Origin(parts.scheme, parts.hostname.lower(), port or _PORTS[parts.scheme])


def _is_loopback(host: str) -> bool:
    if host.lower() == "localhost":
        return True
    return _is_ip_address(host) and ip_address(host).is_loopback


def _is_ip_address(host: str) -> bool:
    try:
        ip_address(host)
    except ValueError:
        return False
    return True

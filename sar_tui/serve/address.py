"""Where views are served, and by which names a browser may call that place."""

import socket
from ipaddress import ip_address
from typing import NamedTuple
from urllib.parse import urlsplit

import msgspec

_PORTS = {"http": 80, "https": 443}


class AddressError(ValueError):
    """Nothing can be served there; one clear sentence."""


class Address(msgspec.Struct, frozen=True):
    """A host and a port, and, where a tunnel or proxy stands before them, the URL under which people reach it.

    Raises:
        AddressError: the public URL is none.
    """

    host: str
    port: int
    public_url: str = ""

    def __post_init__(self) -> None:
        if self.public_url and _place(self.public_url) is None:
            raise AddressError(
                f"{self.public_url} is no public URL: it is http or https, a host and perhaps a port, as in "
                "https://lab.example:8443."
            )

    @property
    def is_loopback(self) -> bool:
        """Whether only this machine reaches it."""
        return _is_loopback(self.host)

    @property
    def is_encrypted(self) -> bool:
        """Whether people reach it over HTTPS."""
        return self.public_url.lower().startswith("https:")

    @property
    def url(self) -> str:
        """What people open, without the token."""
        if self.public_url:
            return self.public_url.rstrip("/") + "/"
        host = _reachable(self.host)
        host = f"[{host}]" if ":" in host else host
        return f"http://{host}:{self.port}/"

    def allows_host(self, host: str) -> bool:
        """Whether a request's ``Host`` names this place.

        A page of somebody else's can have its own name point to this machine (DNS rebinding), so only names that
        nobody else can give are ours: addresses in figures, ``localhost``, and those it was told.
        """
        asked = _place(f"http://{host}")
        if asked is None:
            return False
        _, name, port = asked
        if self.public_url and (public := _place(self.public_url)):
            at_its_own_port = _place(f"{public.scheme}://{host}")
            if at_its_own_port == public:
                return True
        if port != self.port:
            return False
        if self.is_loopback:
            return _is_loopback(name)
        return name in ("localhost", self.host.lower()) or _is_figures(name)

    def allows_origin(self, origin: str, host: str) -> bool:
        """Whether an ``Origin`` is that of a page served here, to a browser that says ``host``, which is ours."""
        page = _place(origin)
        return page is not None and page in (_place(f"http://{host}"), _place(self.public_url))


def _reachable(host: str) -> str:
    """What others can open: in the place of "all networks", this machine's address in the one that leads outwards."""
    if not (_is_figures(host) and ip_address(host).is_unspecified):
        return host
    family, elsewhere = (socket.AF_INET6, "2001:db8::1") if ":" in host else (socket.AF_INET, "192.0.2.1")
    try:
        with socket.socket(family, socket.SOCK_DGRAM) as asked:
            asked.connect((elsewhere, 9))  # sends nothing: it only finds the way there
            return str(asked.getsockname()[0])
    except OSError:  # there is no network: only this machine can open it
        return "::1" if ":" in host else "127.0.0.1"


class _Place(NamedTuple):
    scheme: str
    name: str
    port: int


def _place(url: str) -> _Place | None:
    """What an origin is: scheme, host and port, the usual one filled in. None: it is none."""
    try:
        parts = urlsplit(url)
        port = parts.port
    except ValueError:
        return None
    if parts.scheme not in _PORTS or not parts.hostname or port == 0 or "@" in parts.netloc:
        return None
    if parts.path not in ("", "/") or parts.query or parts.fragment:
        return None
    return _Place(parts.scheme, parts.hostname.lower(), port or _PORTS[parts.scheme])


def _is_loopback(host: str) -> bool:
    if host.lower() == "localhost":
        return True
    return _is_figures(host) and ip_address(host).is_loopback


def _is_figures(host: str) -> bool:
    try:
        ip_address(host)
    except ValueError:
        return False
    return True

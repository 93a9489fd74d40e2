"""Addresses of sensors in the network: ``//HOST:PORT?QUERY``."""

import re
from urllib.parse import urlsplit


def split_address(address: str, scheme: str) -> tuple[str, int | None, str]:
    """Return host, port and query of ``//[HOST][:PORT][?QUERY]``, with or without its scheme.

    Raises ValueError for anything else, such as a host that no network can have.
    """
    parts = urlsplit(address.strip())
    host = parts.hostname or ""
    host.encode("idna")
    if (
        parts.scheme not in ("", scheme)
        or parts.username
        or parts.fragment
        or parts.path not in ("", "/")
        or parts.port == 0
        or not re.fullmatch(r"[\w.:-]*", host)
    ):
        raise ValueError(f"{address} is not an address")
    return host, parts.port, parts.query


def bracketed(host: str) -> str:
    """Return a host as addresses have it: an IPv6 address in brackets."""
    return f"[{host}]" if ":" in host else host

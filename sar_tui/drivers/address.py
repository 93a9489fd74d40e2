"""Addresses of robots and bridges in the network: ``SCHEME://HOST[:PORT][/PATH][?OPTIONS]``."""

import re
from typing import NamedTuple
from urllib.parse import parse_qsl, urlsplit


class AddressError(ValueError):
    """An address is invalid. The message is one or two clear sentences."""


class Address(NamedTuple):
    """A place in the network. Each user of it defines the ``path`` and the ``options``."""

    host: str
    port: int
    path: str
    options: dict[str, str]

    def __str__(self) -> str:
        return f"{self.host}, port {self.port}"

    @property
    def netloc(self) -> str:
        """Host and port as a URL has them: an IPv6 address in brackets."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{host}:{self.port}"


def parse(address: str, scheme: str, port: int, example: str) -> Address:
    """Parse ``SCHEME://HOST[:PORT][/PATH][?NAME=VALUE&…]``, with or without its ``SCHEME:``.

    Args:
        address: the text.
        scheme: what it may begin with.
        port: the port if it names none.
        example: valid forms, for the message of AddressError.

    Raises:
        AddressError: it is not valid.
    """
    try:
        parts = urlsplit(address.strip())
        options = dict(
            parse_qsl(parts.query, keep_blank_values=True, strict_parsing=bool(parts.query))
        )
        known = parts.scheme in ("", scheme) and not parts.username and not parts.fragment
        if known and parts.hostname and re.fullmatch(r"[\w.:-]+", parts.hostname):
            named = port if parts.port is None else parts.port
            return Address(parts.hostname, named, parts.path, options)
    except ValueError:
        pass
    raise AddressError(f'The address "{address}" is not valid. Use {example}.')

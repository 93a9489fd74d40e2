"""Accepted host names, origins and URLs of an address."""

from ipaddress import ip_address
from urllib.parse import urlsplit

import pytest

from sar_tui.serve.address import Address, AddressError

HERE = Address("127.0.0.1", 8000)
LAB = Address("0.0.0.0", 8000)
PROXIED = Address("127.0.0.1", 8000, "https://lab.example")


@pytest.mark.parametrize(
    ("address", "host", "allows_host"),
    [
        (HERE, "127.0.0.1:8000", True),
        (HERE, "localhost:8000", True),
        (HERE, "[::1]:8000", True),
        (HERE, "127.0.0.1:8001", False),
        (HERE, "127.0.0.1", False),
        (HERE, "evil.example:8000", False),
        (HERE, "localhost.evil.example:8000", False),
        (HERE, "192.168.1.4:8000", False),
        (HERE, "", False),
        (HERE, "[:8000", False),
        (HERE, "me@127.0.0.1:8000", False),
        (LAB, "192.168.1.4:8000", True),
        (LAB, "evil.example:8000", False),
        (Address("lab.local", 8000), "lab.local:8000", True),
        (PROXIED, "lab.example", True),
        (PROXIED, "lab.example:443", True),
        (PROXIED, "lab.example:80", False),
        (PROXIED, "127.0.0.1:8000", True),
    ],
)
def test_accepted_hosts(address: Address, host: str, allows_host: bool) -> None:
    assert address.allows_host(host) is allows_host


@pytest.mark.parametrize("host", ["0.0.0.0", "::"])
def test_url_of_a_wildcard_address_can_be_opened(host: str) -> None:
    place = Address(host, 8000)
    named = urlsplit(place.url)
    assert named.hostname
    assert not ip_address(named.hostname).is_unspecified
    assert place.allows_host(named.netloc)


@pytest.mark.parametrize(
    ("address", "origin", "host", "is_allowed"),
    [
        (HERE, "http://127.0.0.1:8000", "127.0.0.1:8000", True),
        (HERE, "http://localhost:8000", "127.0.0.1:8000", False),
        (HERE, "https://127.0.0.1:8000", "127.0.0.1:8000", False),
        (HERE, "http://127.0.0.1:3000", "127.0.0.1:8000", False),
        (HERE, "http://127.0.0.1:8000x", "127.0.0.1:8000", False),
        (HERE, "null", "127.0.0.1:8000", False),
        (HERE, "", "127.0.0.1:8000", False),
        (PROXIED, "https://lab.example", "lab.example", True),
        (PROXIED, "https://lab.example", "127.0.0.1:8000", True),
        (PROXIED, "http://lab.example", "127.0.0.1:8000", False),
        (PROXIED, "https://evil.example", "lab.example", False),
    ],
)
def test_accepted_origins(address: Address, origin: str, host: str, is_allowed: bool) -> None:
    assert address.allows_origin(origin, host) is is_allowed


def test_url_is_the_public_url_if_given() -> None:
    assert (HERE.url, PROXIED.url) == ("http://127.0.0.1:8000/", "https://lab.example/")
    assert Address("::1", 8000).url == "http://[::1]:8000/"


@pytest.mark.parametrize(
    "url",
    [
        "lab.example",
        "ftp://lab.example",
        "https://",
        "https://lab.example/sar",
        "https://lab.example?x",
        "http:",
    ],
)
def test_invalid_public_url_is_refused(url: str) -> None:
    with pytest.raises(AddressError, match="is not a valid public URL"):
        Address("127.0.0.1", 8000, url)

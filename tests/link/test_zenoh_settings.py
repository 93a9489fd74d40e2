"""Zenoh's settings: where a session listens, and what is allowed."""

import os
from pathlib import Path
from typing import Any

import msgspec
import pytest
import zenoh

from sar_tui.link.errors import LinkError
from sar_tui.link.zenoh_settings import (
    Credentials,
    Endpoint,
    Guest,
    TlsFiles,
    config,
    host_settings,
    network_settings,
    parse_endpoint,
    socket_settings,
)

HERE = Endpoint("lab-pc.local", 7447)
SECRET = Credentials("the authority", "the certificate", "the key")
FILES = TlsFiles(Path("/a.pem"), Path("/h.pem"), Path("/h.key"))


def decoded(settings: str) -> dict[str, Any]:
    plain: dict[str, Any] = msgspec.json.decode(settings)
    return plain


def sockets() -> set[str]:
    """Return all sockets that this process has open."""
    found = set()
    for number in os.listdir("/proc/self/fd"):
        try:
            target = os.readlink(f"/proc/self/fd/{number}")
        except FileNotFoundError:
            continue
        if target.startswith("socket:"):
            found.add(target)
    return found


# --- endpoints


@pytest.mark.parametrize(
    ("text", "host", "port"),
    [
        ("lab-pc.local", "lab-pc.local", 7447),
        ("lab-pc.local:7000", "lab-pc.local", 7000),
        ("tls/192.168.1.20:7000", "192.168.1.20", 7000),
        ("0.0.0.0", "0.0.0.0", 7447),
        ("::1", "::1", 7447),
        ("[fe80::1]:7000", "fe80::1", 7000),
        ("[::1]", "::1", 7447),
    ],
)
def test_endpoint_with_and_without_port(text: str, host: str, port: int) -> None:
    assert parse_endpoint(text) == Endpoint(host, port)
    assert parse_endpoint(parse_endpoint(text).locator) == Endpoint(host, port)


@pytest.mark.parametrize(
    "text",
    [
        "",
        ":7447",
        "lab pc",
        "lab-pc:0",
        "lab-pc:99999",
        "lab-pc:x",
        "[::1",
        "[::1]7447",
        "tcp/lab-pc",
        "lab#a=b",
        "-a",
    ],
)
def test_invalid_endpoint_is_refused(text: str) -> None:
    with pytest.raises(LinkError, match=r"lab-pc\.local"):
        parse_endpoint(text)


# --- hosts


def test_host_without_endpoints_opens_no_socket() -> None:
    before = sockets()
    with zenoh.open(config(host_settings("abc"))):
        assert sockets() == before


def test_guest_opens_only_the_socket_to_its_host(tmp_path: Path) -> None:
    path = tmp_path / "s.sock"
    with zenoh.open(config(host_settings("abc", socket=path))):
        listening = sockets()
        with zenoh.open(config(socket_settings(path))):
            ends = sockets() - listening
    assert len(ends) == 2, "one of the guest, one that the host accepted"


def test_host_listens_only_on_its_endpoints_and_does_not_scout(tmp_path: Path) -> None:
    settings = decoded(host_settings("abc", socket=tmp_path / "s.sock", listen=[HERE], files=FILES))
    assert settings["listen"]["endpoints"] == [
        "tls/lab-pc.local:7447",
        f"unixsock-stream/{tmp_path}/s.sock",
    ]
    assert settings["connect"]["endpoints"] == []
    assert not settings["scouting"]["multicast"]["enabled"]
    assert not settings["scouting"]["gossip"]["enabled"]


def test_a_host_cannot_listen_on_the_network_without_certificates() -> None:
    with pytest.raises(ValueError, match="certificates"):
        host_settings("abc", listen=[HERE])


@pytest.mark.parametrize("name", ["a*", "a/b", "**", "", "a b", "$x", "a#b", "a?b", "a\nb"])
def test_name_with_wildcard_or_separator_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match="part of a key"):
        host_settings("abc", guests=[Guest(name, "operator")])
    with pytest.raises(ValueError, match="part of a key"):
        host_settings(name)


# --- guests


def test_guest_does_not_listen_and_verifies_the_host() -> None:
    settings = decoded(network_settings(HERE, SECRET))
    assert settings["listen"]["endpoints"] == []
    assert settings["connect"]["endpoints"] == ["tls/lab-pc.local:7447"]
    assert settings["transport"]["link"]["tls"]["verify_name_on_connect"] is True


def test_private_key_is_not_shown() -> None:
    assert "the key" not in f"{SECRET!r} {SECRET} {network_settings(HERE, SECRET)}"


def test_a_guest_on_the_same_machine_needs_no_certificate(tmp_path: Path) -> None:
    settings = decoded(socket_settings(tmp_path / "s.sock"))
    assert settings["connect"]["endpoints"] == [f"unixsock-stream/{tmp_path}/s.sock"]
    assert "tls" not in settings["transport"]["link"]

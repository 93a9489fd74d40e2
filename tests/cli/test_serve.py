"""Tests of the command `sar-tui serve`; for the server itself, see tests/serve."""

import json
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

import pytest

import sar_tui.serve.browser_view
from sar_tui.cli.common import Home
from sar_tui.cli.serve import _program
from sar_tui.link import discovery, errors
from sar_tui.link.discovery import JoinableSession
from sar_tui.link.errors import LinkError, no_packages
from tests.program import Call


@contextmanager
def serving(*arguments: object) -> Iterator[tuple[subprocess.Popen[str], IO[str], IO[str]]]:
    """Run the command, yield it with its streams, and kill it afterwards."""
    command = [sys.executable, "-m", "sar_tui", "serve", *map(str, arguments)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as process:
        assert process.stdout
        assert process.stderr
        try:
            yield process, process.stdout, process.stderr
        finally:
            process.kill()


@pytest.mark.parametrize(
    ("number", "code", "said"),
    [(signal.SIGINT, 130, "Stopped.\n"), (signal.SIGTERM, 128 + signal.SIGTERM, "")],
)
def test_serves_until_a_signal(
    number: signal.Signals, code: int, said: str, tmp_path: Path
) -> None:
    with serving("observer", "--port", 0, "--data", tmp_path) as (process, out, err):
        address, _, token = out.readline().strip().partition("/?token=")
        assert address.startswith("http://127.0.0.1:")
        assert len(token) == 43
        port = int(address.rpartition(":")[2])
        with socket.create_connection(("127.0.0.1", port)) as caller:
            caller.sendall(f"GET / HTTP/1.0\r\nHost: 127.0.0.1:{port}\r\n\r\n".encode())
            assert caller.recv(100).startswith(b"HTTP/1.0 403")
        assert "refused: no token (/)" in err.readline()
        process.send_signal(number)
        assert process.communicate(timeout=60) == ("", said)
        assert process.returncode == code


def test_json_and_stored_token(tmp_path: Path) -> None:
    token_file = tmp_path / "token"
    printed = []
    options = ("agent", "--port", 0, "--json", "--token-file", token_file, "--data", tmp_path)
    for host in ("0.0.0.0", "127.0.0.1"):
        with serving(*options, "--host", host) as (_, out, err):
            printed.append(json.loads(out.readline()))
            assert host == "127.0.0.1" or "it is not encrypted" in err.readline()
    second, first = printed
    assert set(first) == {"view", "url", "host", "port", "token"}
    assert (first["view"], first["host"]) == ("agent", "127.0.0.1")
    assert first["url"] == f"http://127.0.0.1:{first['port']}/?token={first['token']}"
    assert first["token"] == second["token"] == token_file.read_text().strip()


def test_what_cannot_be_served_is_refused_before_anything_is(
    call: Call, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for path, said in ((tmp_path, "is not a file"), (__file__, "is not an invitation")):
        call("serve operator --port 0 --link", path).refused(said)
    session = JoinableSession("abc1", "keyboard", "l1", 1)
    monkeypatch.setattr(discovery, "joinable_sessions", lambda data: [session])
    said = "begins with nonsense. These can: abc1 (keyboard)."
    call("serve operator --port 0 --session nonsense").refused(said)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        said = f"Port {port} is in use; choose another with --port"
        call("serve observer --port", port).refused(said, code=1)

    def missing() -> None:
        raise LinkError(no_packages())

    monkeypatch.setattr(errors, "need_packages", missing)
    call("serve operator --port 0").refused(no_packages())


@pytest.mark.parametrize("missing", ["textual_serve", "aiohttp"])
def test_missing_extra_is_reported(
    call: Call, monkeypatch: pytest.MonkeyPatch, missing: str
) -> None:
    # restores the attribute, as the import below sets it
    monkeypatch.setattr(sar_tui, "serve", sar_tui.serve)
    for name in [name for name in sys.modules if name.startswith("sar_tui.serve")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, missing, None)
    call("serve observer").refused("pip install -e '.[serve]'")


def test_arguments_of_the_program_cannot_be_injected(tmp_path: Path) -> None:
    tasks, link = str(tmp_path / "tasks"), tmp_path / "an invitation"
    home = Home(tmp_path, (tmp_path / "tasks",))
    program = _program("observer", "--link; rm -rf /", None, home)
    assert program[1:6] == ["-P", "-m", "sar_tui", "wizard", "--observe"]
    assert program[-4:] == ["--tasks", tasks, "--", "--link; rm -rf /"]
    assert _program("agent", None, link, home)[-2:] == ["--link", str(link)]
    named = _program("operator", "s1", None, Home(tmp_path), "anna")
    assert named[-4:] == ["--name", "anna", "--", "s1"]
    followed = _program("operator", None, None, Home(tmp_path), protocol=tmp_path / "praise.toml")
    assert followed[-2:] == ["--protocol", str(tmp_path / "praise.toml")]

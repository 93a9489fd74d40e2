"""Tests of the command `sar-tui serve`; for the server itself, see tests/serve."""

import json
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

import pytest

import sar_tui.serve.browser_view
from sar_tui.cli.common import Home
from sar_tui.cli.serve import _program
from sar_tui.link import discovery, errors, invitation
from sar_tui.link.discovery import JoinableSession
from sar_tui.link.errors import LinkError, no_packages
from tests.link.tls_fixtures import invite_guests
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
    for _ in range(2):
        with serving("agent", "--port", 0, "--json", "--token-file", token_file) as (_, out, _):
            printed.append(json.loads(out.readline()))
    first, second = printed
    assert set(first) == {"view", "url", "host", "port", "token"}
    assert (first["view"], first["host"]) == ("agent", "127.0.0.1")
    assert first["url"] == f"http://127.0.0.1:{first['port']}/?token={first['token']}"
    assert first["token"] == second["token"] == token_file.read_text().strip()


def test_warning_on_other_hosts(tmp_path: Path) -> None:
    options = ("--port", 0, "--host", "0.0.0.0", "--data", tmp_path)
    with serving("observer", *options) as (_, _, err):
        assert "it is not encrypted" in err.readline()


def test_port_in_use_is_reported(call: Call) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        said = f"Port {port} is in use; choose another with --port"
        call("serve observer --port", port).refused(said, code=1)


def test_something_that_is_no_invitation_is_refused_before_anything_is_served(call: Call) -> None:
    with (
        tempfile.TemporaryDirectory(prefix="sar-") as folder,
        socket.socket(socket.AF_UNIX) as listening,
    ):
        listening.bind(f"{folder}/a.sock")
        for path, said in (
            (f"{folder}/a.sock", "is not a file"),
            (folder, "is not a file"),
            (__file__, "is not an invitation"),
        ):
            call("serve operator --port 0 --link", path).refused(said)


def test_a_session_that_is_not_there_is_refused_before_anything_is_served(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = JoinableSession("abc1", "keyboard", "l1", 1)
    monkeypatch.setattr(discovery, "joinable_sessions", lambda data: [session])
    said = "begins with nonsense. These can: abc1 (keyboard)."
    call("serve operator --port 0 --session nonsense").refused(said)


def test_an_operators_invitation_is_not_served_to_observers(
    call: Call, data: Path, tmp_path: Path
) -> None:
    path = tmp_path / "anna.sar-link"
    invitation.write(invite_guests(data).anna, path)
    call("serve observer --port 0 --link", path).refused("ask for an observer's invitation")


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


def test_missing_link_packages_are_reported(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing() -> None:
        raise LinkError(no_packages())

    monkeypatch.setattr(errors, "need_packages", missing)
    call("serve operator --port 0").refused(no_packages())


def test_arguments_of_the_program_cannot_be_injected(tmp_path: Path) -> None:
    tasks, link = str(tmp_path / "tasks"), tmp_path / "an invitation"
    home = Home(tmp_path, (tmp_path / "tasks",))
    program = _program("observer", "--link; rm -rf /", None, home)
    assert program[1:6] == ["-P", "-m", "sar_tui", "wizard", "--observe"]
    assert program[-4:] == ["--tasks", tasks, "--", "--link; rm -rf /"]
    assert _program("agent", None, link, home)[-2:] == ["--link", str(link)]
    named = _program("operator", "s1", None, Home(tmp_path), "anna")
    assert named[-4:] == ["--name", "anna", "--", "s1"]

"""Discovery of sessions on this machine."""

import errno
import os
import signal
import stat
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from sar_tui.link import discovery
from sar_tui.link.discovery import (
    JoinableSession,
    announce,
    live_sessions,
    socket_folder,
    socket_path,
)
from sar_tui.link.errors import LinkError

HERE = JoinableSession("1a2b3c4d5e", "keyboard", "1a2b3c4d5e", os.getpid())

ANNOUNCE = """
import sys
from sar_tui.link.discovery import JoinableSession, announce
with announce(JoinableSession("feedbeef00", "reaching", "feedbeef00", 1)) as path:
    path.touch()
    print("announced", flush=True)
    sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def runtime(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The user's runtime folder. Its path is short, as that of a socket must be."""
    with TemporaryDirectory(prefix="sar-") as folder:
        monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
        monkeypatch.setattr(discovery, "_RUNTIME_FOLDERS", f"{folder}/run")
        yield Path(folder)


def test_the_folder_is_made_for_this_user_alone(runtime: Path) -> None:
    assert socket_folder() == runtime / "sar-tui"
    assert stat.S_IMODE(socket_folder().stat().st_mode) == 0o700


@pytest.mark.parametrize("configured", ["", "/there/is/none"])
def test_without_a_runtime_folder_it_is_in_the_usual_one_or_else_the_temporary_folder(
    configured: str, runtime: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", configured)
    monkeypatch.setattr(discovery.tempfile, "gettempdir", lambda: str(runtime))
    assert socket_folder() == runtime / f"sar-tui-{os.getuid()}"
    usual = runtime / "run" / str(os.getuid())
    usual.mkdir(parents=True, mode=0o700)
    monkeypatch.delenv("XDG_RUNTIME_DIR")
    assert socket_folder() == usual / "sar-tui"


@pytest.mark.parametrize(
    ("spoil", "why"),
    [
        (lambda folder: folder.mkdir(mode=0o750), "is accessible to others"),
        (lambda folder: folder.symlink_to(folder.parent), "is a symbolic link"),
        (lambda folder: folder.touch(mode=0o600), "is not a folder"),
    ],
)
def test_a_folder_that_is_not_private_to_this_user_is_refused(
    runtime: Path, spoil: Callable[[Path], object], why: str
) -> None:
    spoil(runtime / "sar-tui")
    with pytest.raises(LinkError, match=why):
        socket_folder()


def test_a_folder_of_another_user_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    owner = socket_folder().stat().st_uid
    monkeypatch.setattr(discovery.os, "getuid", lambda: owner + 1)
    with pytest.raises(
        LinkError, match=r"belongs to somebody else.* Set XDG_RUNTIME_DIR to a folder that only you"
    ):
        socket_folder()


def test_files_of_a_session_can_be_read_by_this_user_alone() -> None:
    before = os.umask(0)
    try:
        with announce(HERE) as path:
            modes = {each.name: stat.S_IMODE(each.stat().st_mode) for each in path.parent.iterdir()}
    finally:
        os.umask(before)
    assert modes == {"1a2b3c4d5e.json": 0o600, "1a2b3c4d5e.live": 0o600}


def test_without_unix_sockets_the_network_is_offered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(discovery.os, "name", "nt")
    with pytest.raises(LinkError, match="link invite"):
        socket_folder()


def test_a_path_that_is_too_long_for_a_socket_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    long = tmp_path / ("x" * 90)
    long.mkdir()
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(long))
    with pytest.raises(LinkError, match="XDG_RUNTIME_DIR"):
        socket_path("1a2b3c4d5e")


@pytest.mark.parametrize("session", ["", "../x", "a/b", "a.b", "x\n"])
def test_invalid_session_id_is_refused(session: str) -> None:
    with pytest.raises(LinkError, match="is not a session's id"):
        socket_path(session)


def test_session_is_found_while_announced_by_one_program_and_leaves_no_files() -> None:
    assert live_sessions() == []
    with announce(HERE) as path:
        assert path == HERE.socket == socket_folder() / "1a2b3c4d5e.sock"
        with pytest.raises(LinkError, match="Another program"), announce(HERE):
            pass
        assert live_sessions() == [HERE]
    assert live_sessions() == []
    assert list(socket_folder().iterdir()) == []


def test_full_disk_is_reported_and_leaves_no_files(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with (
        pytest.raises(LinkError, match="cannot be written to: No space left on device"),
        announce(HERE),
    ):
        pass
    assert list(socket_folder().iterdir()) == []


def test_files_of_a_killed_program_are_removed() -> None:
    with (
        announce(HERE),
        subprocess.Popen(
            [sys.executable, "-c", ANNOUNCE], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        ) as other,
    ):
        try:
            assert other.stdout is not None
            assert other.stdout.readline() == b"announced\n"
            assert [live.session for live in live_sessions()] == ["1a2b3c4d5e", "feedbeef00"]
            other.send_signal(signal.SIGKILL)
            other.wait()
        finally:
            other.kill()
        assert socket_path("feedbeef00").exists()
        assert live_sessions() == [HERE]
        assert not list(socket_folder().glob("feedbeef00*"))


@pytest.mark.parametrize(
    "content", [b"", b"{", b'{"session": "another", "task": "", "link": "", "pid": 1}']
)
def test_invalid_description_is_ignored(content: bytes) -> None:
    with announce(HERE) as path:
        path.with_suffix(".json").write_bytes(content)
        assert live_sessions() == []

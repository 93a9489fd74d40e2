"""Where sessions that an operator on the same machine may join leave their sockets: a folder of this user's alone.

Each has three files by the session's id: ``ID.sock``, which zenoh makes; ``ID.json``, which says what it is; and
``ID.live``, locked for as long as the program runs, however it ends.
"""

import contextlib
import os
import re
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path

import filelock
import msgspec

from sar_tui.link.errors import LinkError

LONGEST_PATH = 100
"""Bytes; the system allows a socket's path 108 (Linux) or 104 (macOS)."""
_LARGEST = 64 * 1024
_PATIENCE_SECONDS = 0.5
"""For so long a lock that is taken is asked for again: ``live`` of another program takes it for a moment."""


class JoinableSession(msgspec.Struct, frozen=True):
    """A session that an operator can join: ``link`` is the id of its link, ``pid`` of the participant's program."""

    session: str
    task: str
    link: str
    pid: int

    @property
    def socket(self) -> Path:
        """Where it listens."""
        return socket_path(self.session)


def socket_folder() -> Path:
    """The folder, made if need be: ``$XDG_RUNTIME_DIR/sar-tui``, else ``sar-tui-UID`` among the temporary files.

    Raises:
        LinkError: this system has no Unix sockets, or the folder is not this user's alone.
    """
    if os.name != "posix":
        raise LinkError(
            "An operator on the same machine needs Unix sockets, which this system does not have. Invite them, and let "
            "the session listen on the network instead: sar-tui link invite operator --name NAME --host 127.0.0.1"
        )
    runtime = os.environ.get("XDG_RUNTIME_DIR", "")
    if runtime and os.access(runtime, os.W_OK | os.X_OK):
        folder = Path(runtime) / "sar-tui"
    else:
        folder = Path(tempfile.gettempdir()) / f"sar-tui-{os.getuid()}"
    try:
        with contextlib.suppress(FileExistsError):
            folder.mkdir(mode=0o700)
        found = folder.lstat()
    except OSError as error:
        raise LinkError(f"{folder}, the place for an operator's socket, cannot be made: {error.strerror}.") from None
    reason = _unsafe(found)
    if reason:
        raise LinkError(f"{folder} {reason}, so no session can be steered through it safely. Remove it and try again.")
    return folder


def socket_path(session: str) -> Path:
    """Where a session listens. Raises LinkError: as ``place``, or the path is too long for a socket."""
    if not re.fullmatch(r"[A-Za-z0-9_-]+", session):
        raise LinkError(f"{session!r} is not a session's id.")
    path = socket_folder() / f"{session}.sock"
    if len(os.fsencode(path)) > LONGEST_PATH:
        raise LinkError(
            f"{path} is too long for a socket's path. Set XDG_RUNTIME_DIR to a folder of yours with a short name."
        )
    return path


@contextlib.contextmanager
def announce(live: JoinableSession) -> Iterator[Path]:
    """Let operators find a session for as long as the block runs; its socket's path.

    Raises:
        LinkError: as ``socket_path``, or another program announces that session.
    """
    path = socket_path(live.session)
    lock = filelock.FileLock(path.with_suffix(".live"), mode=0o600)
    try:
        lock.acquire(timeout=_PATIENCE_SECONDS)
    except filelock.Timeout:
        raise LinkError(f"Another program lets operators join the session {live.session}.") from None
    except OSError as error:
        raise LinkError(f"{path.parent} cannot be written to: {error.strerror}.") from None
    try:
        try:
            half = path.with_suffix(".half")
            half.write_bytes(msgspec.json.encode(live))
            half.replace(path.with_suffix(".json"))
        except OSError as error:
            raise LinkError(f"{path.parent} cannot be written to: {error.strerror}.") from None
        yield path
    finally:
        _clear(path)
        lock.release()


def live_sessions() -> list[JoinableSession]:
    """The sessions that can be joined now, by id. What a program that was killed left is cleared away.

    Raises LinkError: as ``place``.
    """
    found = []
    for description in sorted(socket_folder().glob("*.json")):
        if _cleared_if_over(description.with_suffix(".sock")):
            continue
        with contextlib.suppress(OSError, msgspec.MsgspecError):
            with description.open("rb") as file:
                live = msgspec.json.decode(file.read(_LARGEST), type=JoinableSession)
            if live.session == description.stem:
                found.append(live)
    return found


def _unsafe(found: os.stat_result) -> str:
    if stat.S_ISLNK(found.st_mode):
        return "is a link to another place"
    if not stat.S_ISDIR(found.st_mode):
        return "is not a folder"
    if found.st_uid != os.getuid():
        return "belongs to somebody else"
    if stat.S_IMODE(found.st_mode) & 0o077:
        return "is open to others"
    return ""


def _cleared_if_over(socket: Path) -> bool:
    """Whether no program announces that session any more; what it left is taken away then."""
    lock = filelock.FileLock(socket.with_suffix(".live"), mode=0o600)
    try:
        lock.acquire(blocking=False)
    except (filelock.Timeout, OSError):
        return False
    try:
        _clear(socket)
    finally:
        lock.release()
    return True


def _clear(socket: Path) -> None:
    """Take away what belongs to a session. Zenoh keeps a lock of its own beside its socket."""
    for suffix in (".json", ".half", ".sock", ".sock.lock", ".live"):
        with contextlib.suppress(OSError):
            socket.with_suffix(suffix).unlink()

"""Discovery of sessions on the same machine, through a folder that is private to this user.

Each session has three files there: ``ID.sock``, made by Zenoh; ``ID.json``, its description; and
``ID.live``, a lock held for as long as its program runs.
"""

import contextlib
import os
import re
import stat
import tempfile
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path

import filelock
import msgspec

from sar_tui.link.errors import LinkError
from sar_tui.model.language import ENGLISH, Language

MAX_PATH_BYTES = 100
"""For a socket's path, the system allows 108 bytes (Linux) or 104 (macOS)."""
_RUNTIME_FOLDERS = "/run/user"
"""Folder in which systemd makes each user's runtime folder, also if the variable is missing, as
after ``su``.
"""
_ELSEWHERE = (
    "Set XDG_RUNTIME_DIR to a folder that only you can use, with a short path, for the "
    "session and for its operators."
)
_MAX_FILE_BYTES = 64 * 1024
_LOCK_TIMEOUT_S = 0.5
"""``live_sessions`` in another program may hold the lock for a moment."""


class JoinableSession(msgspec.Struct, frozen=True):
    """Session that an operator can join.

    ``link`` is the id of its link, ``pid`` that of its program, ``data`` the path of its data
    folder (see `folder_name`). ``participants``: their codes. ``started``: when its program began
    it (UTC, ISO 8601).
    """

    session: str
    task: str
    link: str
    pid: int
    data: str = ""
    participants: tuple[str, ...] = ()
    started: str = ""

    def description(self, tr: Language = ENGLISH) -> str:
        """Return participant, task, and start in local time: "P01, keyboard, since 14:03"."""
        parts = [f" {tr('and')} ".join(self.participants), self.task]
        with contextlib.suppress(ValueError):
            began = datetime.fromisoformat(self.started).astimezone()
            is_today = began.date() == datetime.now().astimezone().date()
            time = f"{began:%H:%M}" if is_today else f"{began:%Y-%m-%d %H:%M}"
            parts.append(tr("since {time}", time=time))
        return ", ".join(filter(None, parts))

    @property
    def socket(self) -> Path:
        """Path of its socket."""
        return socket_path(self.session)


def socket_folder(*, create: bool = True) -> Path:
    """Return the folder: ``sar-tui`` in the user's runtime folder, else ``sar-tui-UID`` in the
    temporary folder. The runtime folder is ``$XDG_RUNTIME_DIR``, else its usual place.

    Args:
        create: False if it may be missing.

    Raises:
        LinkError: this system has no Unix sockets, or the folder is not private to this user.
    """
    if os.name != "posix":
        raise LinkError(
            "An operator on the same machine needs Unix sockets, which this system does not have. "
            "Invite them, and let "
            "the session listen on the network instead: sar-tui link invite operator --name NAME "
            "--host 127.0.0.1"
        )
    places = os.environ.get("XDG_RUNTIME_DIR", ""), f"{_RUNTIME_FOLDERS}/{os.getuid()}"
    runtime = next(filter(_is_usable, places), "")
    folder = (
        Path(runtime) / "sar-tui"
        if runtime
        else Path(tempfile.gettempdir()) / f"sar-tui-{os.getuid()}"
    )
    try:
        if create:
            with contextlib.suppress(FileExistsError):
                folder.mkdir(mode=0o700)
        elif not os.path.lexists(folder):
            return folder
        found = folder.lstat()
    except OSError as error:
        raise LinkError(
            f"{folder}, the folder for an operator's socket, cannot be created: {error.strerror}. "
            f"{_ELSEWHERE}"
        ) from None
    if reason := _why_unsafe(found):
        advice = "Remove it and try again." if found.st_uid == os.getuid() else _ELSEWHERE
        raise LinkError(f"{folder} {reason}, so it is not safe to use. {advice}")
    return folder


def _is_usable(runtime: str) -> bool:
    """Return True if a runtime folder exists and this user may create files there."""
    return bool(runtime) and os.path.isdir(runtime) and os.access(runtime, os.W_OK | os.X_OK)


def socket_path(session: str) -> Path:
    """Return the path of a session's socket. Raises LinkError as ``socket_folder``, or if the path
    is too long.
    """
    if not re.fullmatch(r"[A-Za-z0-9_-]+", session):
        raise LinkError(f"{session!r} is not a session's id.")
    path = socket_folder() / f"{session}.sock"
    if len(os.fsencode(path)) > MAX_PATH_BYTES:
        raise LinkError(
            f"{path} is too long for a socket's path. Set XDG_RUNTIME_DIR to a folder of yours "
            "with a short path."
        )
    return path


@contextlib.contextmanager
def announce(live: JoinableSession) -> Iterator[Path]:
    """Announce a session for the duration of the block; yields the path of its socket.

    Raises:
        LinkError: as ``socket_path``, or another program announces that session.
    """
    path = socket_path(live.session)
    lock = filelock.FileLock(path.with_suffix(".live"), mode=0o600)
    try:
        lock.acquire(timeout=_LOCK_TIMEOUT_S)
    except filelock.Timeout:
        raise LinkError(
            f"Another program already runs the session {live.session} with an operator."
        ) from None
    except OSError as error:
        raise LinkError(f"{path.parent} cannot be written to: {error.strerror}.") from None
    try:
        try:
            half = path.with_suffix(".half")
            half.touch(mode=0o600)
            half.write_bytes(msgspec.json.encode(live))
            half.replace(path.with_suffix(".json"))
        except OSError as error:
            raise LinkError(f"{path.parent} cannot be written to: {error.strerror}.") from None
        yield path
    finally:
        _clear(path)
        lock.release()


def folder_name(data: Path) -> str:
    """Return the name by which programs agree on a data folder: its path, with symbolic links
    resolved.
    """
    return os.path.realpath(data)


def joinable_sessions(data: Path) -> list[JoinableSession]:
    """Return the sessions of a data folder that can be joined, ordered by id. Raises LinkError as
    ``socket_folder``.
    """
    name = folder_name(data)
    return [live for live in live_sessions() if live.data == name]


def other_folders(data: Path) -> list[str]:
    """Return the other data folders with sessions that can be joined. Raises LinkError as
    ``socket_folder``.
    """
    return sorted({live.data for live in live_sessions()} - {folder_name(data), ""})


def live_sessions() -> list[JoinableSession]:
    """Return the sessions on this machine that can be joined, of all data folders, ordered by id.

    Files left behind by killed programs are removed.

    Raises LinkError as ``socket_folder``.
    """
    found = []
    for description in sorted(socket_folder(create=False).glob("*.json")):
        if _clear_if_over(description.with_suffix(".sock")):
            continue
        with contextlib.suppress(OSError, msgspec.MsgspecError):
            with description.open("rb") as file:
                live = msgspec.json.decode(file.read(_MAX_FILE_BYTES), type=JoinableSession)
            if live.session == description.stem:
                found.append(live)
    return found


def _why_unsafe(found: os.stat_result) -> str:
    if stat.S_ISLNK(found.st_mode):
        return "is a symbolic link"
    if not stat.S_ISDIR(found.st_mode):
        return "is not a folder"
    if found.st_uid != os.getuid():
        return "belongs to somebody else"
    if stat.S_IMODE(found.st_mode) & 0o077:
        return "is accessible to others"
    return ""


def _clear_if_over(socket: Path) -> bool:
    """Remove the files of a session that no program announces any more, and return whether they
    were removed.
    """
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
    """Remove a session's files, and the lock that Zenoh keeps beside its socket."""
    for suffix in (".json", ".half", ".sock", ".sock.lock", ".live"):
        with contextlib.suppress(OSError):
            socket.with_suffix(suffix).unlink()

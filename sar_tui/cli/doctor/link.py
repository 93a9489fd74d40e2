"""What `sar-tui doctor` finds of operators' ways in: on this machine, over the network, and in a browser."""

import os
import socket
import stat
from datetime import UTC, datetime, timedelta
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from sar_tui.cli.doctor.check import Finding

if TYPE_CHECKING:
    from sar_tui.link.authority import IssuedInvitation

_SOON = timedelta(days=7)
"""An invitation that ends within this time is told of."""
_NO_OPERATOR = "Only a session with an operator needs it."


def operator_here() -> Finding:
    """Whether an operator on this machine could join a session: a socket is opened in the folder, and taken away."""
    from sar_tui.link.discovery import live_sessions, socket_path
    from sar_tui.link.errors import LinkError, need_packages

    name = "Operator here"
    try:
        need_packages()
    except LinkError as error:
        return _without(name, str(error), _NO_OPERATOR)
    try:
        path = socket_path(f"doctor-{os.getpid()}")
        found = live_sessions()
    except LinkError as error:
        return Finding(name, "care", str(error), _NO_OPERATOR)
    try:
        with socket.socket(socket.AF_UNIX) as tried:
            tried.bind(str(path))
    except OSError as error:
        why = f"no socket can be opened in {path.parent}: {error.strerror}"
        return Finding(name, "care", why, "Set XDG_RUNTIME_DIR to a folder of yours on a disk of this machine.")
    finally:
        path.unlink(missing_ok=True)
    count = "no session" if not found else "1 session" if len(found) == 1 else f"{len(found)} sessions"
    return Finding(name, "ok", f"through {path.parent}, open to you alone; {count} can be joined now")


def invitations(folder: Path, now: datetime | None = None) -> Finding:
    """Whether anybody was invited to the sessions of a data folder, until when, and whether the keys are private."""
    from sar_tui.link.authority import FOLDER, Authority
    from sar_tui.link.errors import LinkError

    name = "Invitations"
    if not Authority.exists(folder):
        return Finding(name, "ok", "nobody is invited, so nobody can join over the network")
    try:
        issued = Authority.open(folder).invitations
    except LinkError as error:
        return Finding(name, "bad", str(error), "Until then no session can listen on the network.")
    keys = folder / FOLDER
    if os.name == "posix" and stat.S_IMODE(keys.stat().st_mode) & 0o077:
        return Finding(
            name,
            "care",
            f"others on this machine can look into {keys}, where certificates are made",
            f"Say chmod 700 {keys}; if somebody may have looked, move that folder away, and invite everybody anew.",
        )
    return _good(name, issued, now or datetime.now(UTC))


def browser() -> Finding:
    """Whether a panel can be shown in a browser."""
    from sar_tui.link.errors import LinkError, need_packages

    if find_spec("textual_serve") is None or find_spec("aiohttp") is None:
        return _without("Browser", "pip install 'sar-tui[serve]'", "Only `sar-tui serve` needs it.")
    try:
        need_packages()
    except LinkError as error:
        return _without("Browser", str(error), "`sar-tui serve` needs the link, too.")
    return Finding("Browser", "ok", "`sar-tui serve` can show a panel; nothing is served until then")


def _good(name: str, issued: "tuple[IssuedInvitation, ...]", now: datetime) -> Finding:
    good = [each for each in issued if each.state(now) == "good"]
    if not good:
        return Finding(name, "ok", "none that is good now, so nobody can join over the network")
    found = f"{len(good)} good: {', '.join(str(each.guest) for each in good)}"
    if soon := [each for each in good if each.expires - now < _SOON]:
        ends = ", ".join(f"{each.name} on {each.expires:%Y-%m-%d}" for each in soon)
        return Finding(name, "care", f"{found}; soon over: {ends}", "A new name can be invited at any time.")
    return Finding(name, "ok", found)


def _without(name: str, how: str, who: str) -> Finding:
    """What it takes is not installed, which is no fault; the cure stands after a colon, if not alone."""
    return Finding(name, "ok", f"not installed. {who}", f"To have it: {how.rpartition(': ')[2]}")

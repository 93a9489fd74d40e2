"""Checks of `sar-tui doctor` on how operators join: on this machine, over the network, and in a
browser.
"""

import os
import socket
import stat
from datetime import UTC, datetime, timedelta
from importlib.util import find_spec
from typing import TYPE_CHECKING

from sar_tui.cli.doctor.finding import Finding, Machine, bad, care, not_installed, ok
from sar_tui.drivers.installation import pip_install_extra

if TYPE_CHECKING:
    from sar_tui.link.authority import IssuedInvitation

_SOON = timedelta(days=7)
"""Invitations that expire within this time are reported."""
_NO_OPERATOR = "Only sessions with an operator need it."


def operator_here(_: Machine) -> Finding:
    """Check whether an operator on this machine can join a session, by opening a socket in the
    folder.
    """
    from sar_tui.link.discovery import live_sessions, socket_path
    from sar_tui.link.errors import LinkError, need_packages

    try:
        need_packages()
    except LinkError as error:
        return not_installed(str(error), _NO_OPERATOR)
    try:
        path = socket_path(f"doctor-{os.getpid()}")
        found = live_sessions()
    except LinkError as error:
        return care(str(error), _NO_OPERATOR)
    try:
        with socket.socket(socket.AF_UNIX) as opened:
            opened.bind(str(path))
    except OSError as error:
        why = f"no socket can be opened in {path.parent}: {error.strerror}"
        return care(why, "Set XDG_RUNTIME_DIR to a folder of yours on a local disk.")
    finally:
        path.unlink(missing_ok=True)
    count = (
        "no session" if not found else "1 session" if len(found) == 1 else f"{len(found)} sessions"
    )
    return ok(f"through {path.parent}, private to you; {count} can be joined now")


def invitations(here: Machine) -> Finding:
    """Check the invitations to a data folder's sessions, their expiry, and whether its keys are
    private.
    """
    from sar_tui.link.authority import FOLDER, Authority
    from sar_tui.link.errors import LinkError

    folder = here.home.folder
    if not Authority.exists(folder):
        return ok("nobody is invited, so nobody can join over the network")
    try:
        issued = Authority.open(folder).invitations
    except LinkError as error:
        return bad(str(error), "Until then no session can listen on the network.")
    keys = folder / FOLDER
    if os.name == "posix" and stat.S_IMODE(keys.stat().st_mode) & 0o077:
        return care(
            f"other users can read {keys}, which holds the certificate authority",
            f"Run chmod 700 {keys}. If somebody may have read it, move it away and make all "
            "invitations again.",
        )
    return _check_expiry(issued, datetime.now(UTC))


def browser(_: Machine) -> Finding:
    """Check whether a panel can be shown in a browser."""
    from sar_tui.link.errors import LinkError, need_packages

    if find_spec("textual_serve") is None or find_spec("aiohttp") is None:
        return not_installed(pip_install_extra("serve"), "Only `sar-tui serve` needs it.")
    try:
        need_packages()
    except LinkError as error:
        return not_installed(str(error), "`sar-tui serve` needs the link.")
    return ok("`sar-tui serve` can show a panel")


def _check_expiry(issued: "tuple[IssuedInvitation, ...]", now: datetime) -> Finding:
    valid = [each for each in issued if each.state(now) == "good"]
    if not valid:
        return ok("none is valid now, so nobody can join over the network")
    found = f"{len(valid)} valid: {', '.join(str(each.guest) for each in valid)}"
    if soon := [each for each in valid if each.expires - now < _SOON]:
        ends = ", ".join(f"{each.name} on {each.expires:%Y-%m-%d}" for each in soon)
        return care(f"{found}; expiring soon: {ends}", "Invite them again under a new name.")
    return ok(found)

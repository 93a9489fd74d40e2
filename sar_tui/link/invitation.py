"""An invitation: the one file that lets a person on another machine watch or steer a session.

The file is a key: it holds the private key of the certificate that was made for its bearer. Whoever has the file is
that operator or observer, until it expires or is revoked.
"""

import contextlib
import os
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any, get_args

import msgspec

from sar_tui.framework.messages import Role
from sar_tui.link.errors import LinkError, need_packages
from sar_tui.link.settings import Credentials, Endpoint, Guest, parse_endpoint

FORMAT = "sar-tui invitation"
VERSION = 1
SUFFIX = ".sar-link"
LARGEST = 64 * 1024
"""Bytes; an invitation has about 2,500."""
NAME = r"^[A-Za-z0-9][A-Za-z0-9_-]{0,31}\Z"
"""What a guest may be called: a part of a key, of a certificate, and of a file's name."""


class Invitation(msgspec.Struct, frozen=True, kw_only=True):
    """Who is invited, where to, and with what.

    ``link``: the id of the host's link; ``endpoints``: where the host can be reached, to be tried in order;
    ``expires``: when the certificate does.
    """

    role: Role
    name: Annotated[str, msgspec.Meta(pattern=NAME)]
    link: Annotated[str, msgspec.Meta(pattern=r"^[0-9a-f]{8,32}\Z")]
    endpoints: Annotated[tuple[str, ...], msgspec.Meta(min_length=1, max_length=8)]
    expires: datetime
    credentials: Credentials

    @property
    def guest(self) -> Guest:
        return Guest(self.name, self.role)

    @property
    def where(self) -> tuple[Endpoint, ...]:
        return tuple(parse_endpoint(text) for text in self.endpoints)


def file_name(guest: Guest) -> str:
    """What an invitation's file is called unless told otherwise: ``operator-anna.sar-link``."""
    return f"{guest.role}-{guest.name}{SUFFIX}"


def write(invitation: Invitation, path: Path) -> None:
    """Make the file, readable to this user alone.

    Raises:
        LinkError: there is a file of that name already, or it cannot be made.
    """
    plain = {"format": FORMAT, "version": VERSION, **msgspec.to_builtins(invitation)}
    text = msgspec.json.format(msgspec.json.encode(plain), indent=1) + b"\n"
    try:
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    except FileExistsError:
        raise LinkError(f"{path} is there already, and is left as it is. Give another name with --to.") from None
    except OSError as error:
        raise LinkError(f"{path} cannot be made: {error.strerror}.") from None
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(text)
    except OSError as error:
        with contextlib.suppress(OSError):
            path.unlink()
        raise LinkError(f"{path} cannot be written: {error.strerror}.") from None


def read(path: Path, now: datetime | None = None) -> Invitation:
    """Read an invitation, and see that it is whole and still good.

    Raises:
        LinkError: there is no such file, it is not an invitation, is damaged, of a newer version, for a role unknown to
            this one, or has expired; or what certificates are read with is not installed.
    """
    invitation = _decoded(_content(path), path)
    need_packages()
    from sar_tui.link import certificates

    try:
        _ = invitation.where
        expires = certificates.expiry(invitation.credentials, str(invitation.guest))
    except (ValueError, LinkError):
        raise _damaged(path) from None
    if expires <= (now or datetime.now(UTC)):
        raise LinkError(f"The invitation {path} expired on {expires:%Y-%m-%d at %H:%M} UTC. Ask for a new one.")
    return msgspec.structs.replace(invitation, expires=expires)


def _content(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
    except FileNotFoundError:
        raise LinkError(f"There is no file {path}.") from None
    except OSError as error:
        raise LinkError(f"{path} cannot be read: {error.strerror}.") from None
    if FORMAT.encode() not in content[:200] or len(content) > LARGEST:
        raise LinkError(
            f"{path} is not an invitation. Those are made by `sar-tui link invite`, and end in {SUFFIX} as a rule."
        )
    return content


def _decoded(content: bytes, path: Path) -> Invitation:
    try:
        plain = msgspec.json.decode(content, type=dict[str, Any])
        version = plain.pop("version")
        if isinstance(version, int) and version > VERSION:
            raise LinkError(
                f"The invitation {path} was made by a newer sar-tui than this one. Update the one on this machine."
            )
        role = plain.get("role")
        if isinstance(role, str) and role not in get_args(Role):
            raise LinkError(f"The invitation {path} is for the role {role!r}, which this sar-tui does not know.")
        return msgspec.convert(plain, Invitation)
    except (msgspec.MsgspecError, KeyError):
        raise _damaged(path) from None


def _damaged(path: Path) -> LinkError:
    return LinkError(f"The invitation {path} is damaged. Copy it again, whole, or ask for a new one.")

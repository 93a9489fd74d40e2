"""Invitations: files that let a person on another machine watch or operate a session, or a home
dial out to the clinic's router.

The file contains the private key of the guest's certificate. Anyone who has the file can join as
that operator or observer until it expires or is revoked.
"""

import re
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any, get_args

import msgspec

from sar_tui.drivers.files import write_private
from sar_tui.link.errors import LinkError, need_packages
from sar_tui.link.zenoh_settings import (
    Credentials,
    Endpoint,
    Guest,
    InvitedAs,
    parse_endpoint,
)

FORMAT = "sar-tui invitation"
VERSION = 1
SUFFIX = ".sar-link"
MAX_FILE_BYTES = 64 * 1024
"""An invitation has about 2,500 bytes."""
FOLDER = "link"
"""Folder of the link's files in a data folder."""
NAME = r"^[A-Za-z0-9][A-Za-z0-9_-]{0,31}\Z"
"""Pattern of a guest's name, which is used in keys, certificates and file names."""


class Invitation(msgspec.Struct, frozen=True, kw_only=True):
    """Contents of an invitation.

    ``link``: the id of the host's link; ``endpoints``: the host's addresses, to be tried in order;
    ``expires``: of the certificate. ``router``: they are the addresses of a router, through which
    operators and observers visit homes.
    """

    role: InvitedAs
    name: Annotated[str, msgspec.Meta(pattern=NAME)]
    link: Annotated[str, msgspec.Meta(pattern=r"^[0-9a-f]{8,32}\Z")]
    endpoints: Annotated[tuple[str, ...], msgspec.Meta(min_length=1, max_length=8)]
    expires: datetime
    credentials: Credentials
    router: bool = False

    @property
    def guest(self) -> Guest:
        return Guest(self.name, self.role)

    @property
    def where(self) -> tuple[Endpoint, ...]:
        return tuple(parse_endpoint(text) for text in self.endpoints)


def check_name(name: str) -> None:
    """Raise LinkError if a guest cannot have this name."""
    if not re.fullmatch(NAME, name):
        raise LinkError(
            f"{name!r} cannot be a guest's name. Use at most 32 letters, digits, - and _, as in "
            "lab-2."
        )


def file_name(guest: Guest) -> str:
    """Return the default name of an invitation's file: ``operator-op1.sar-link``."""
    return f"{guest.role}-{guest.name}{SUFFIX}"


def home_file(data: Path) -> Path:
    """Return the path of a home's invitation in its data folder; there is one if its sessions dial
    out.
    """
    return data / FOLDER / f"home{SUFFIX}"


def write(invitation: Invitation, path: Path) -> None:
    """Write the file, readable only by this user.

    Raises:
        LinkError: the file exists already, or cannot be written.
    """
    plain = {"format": FORMAT, "version": VERSION, **msgspec.to_builtins(invitation)}
    text = msgspec.json.format(msgspec.json.encode(plain), indent=1).decode() + "\n"
    try:
        write_private(path, text)
    except FileExistsError:
        raise LinkError(f"{path} already exists. Give another name with --to.") from None
    except OSError as error:
        raise LinkError(f"{path} cannot be created: {error.strerror}.") from None


def read(path: Path, now: datetime | None = None, *, is_known: bool = False) -> Invitation:
    """Read an invitation and check that it is intact and has not expired.

    Args:
        path: of the file.
        now: the time.
        is_known: the certificate was checked before, and is not again: loading what that needs
            takes a moment.

    Raises:
        LinkError: the file is missing, not an invitation, damaged, of a newer version, for an
            unknown role, or has expired; or the link's packages are not installed.
    """
    invitation = _decoded(_content(path), path)
    need_packages()
    try:
        _ = invitation.where
        expires = invitation.expires
        if not is_known:
            from sar_tui.link import certificates

            expires = certificates.expiry(invitation.credentials, str(invitation.guest))
    except (ValueError, LinkError):
        raise _damaged(path) from None
    if expires <= (now or datetime.now(UTC)):
        raise LinkError(
            f"The invitation {path} expired on {expires:%Y-%m-%d at %H:%M} UTC. Ask for a new one."
        )
    return msgspec.structs.replace(invitation, expires=expires)


def _content(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            content = file.read(MAX_FILE_BYTES + 1)
    except FileNotFoundError:
        raise LinkError(f"There is no file {path}.") from None
    except OSError as error:
        raise LinkError(f"{path} cannot be read: {error.strerror}.") from None
    if FORMAT.encode() not in content[:200] or len(content) > MAX_FILE_BYTES:
        raise LinkError(
            f"{path} is not an invitation. Invitations are made by `sar-tui link invite`, and "
            f"usually end in {SUFFIX}."
        )
    return content


def _decoded(content: bytes, path: Path) -> Invitation:
    try:
        plain = msgspec.json.decode(content, type=dict[str, Any])
        version = plain.pop("version")
        if isinstance(version, int) and version > VERSION:
            raise LinkError(
                f"The invitation {path} was made by a newer sar-tui than this one. Update the one "
                "on this machine."
            )
        role = plain.get("role")
        if isinstance(role, str) and role not in get_args(InvitedAs):
            raise LinkError(
                f"The invitation {path} is for the role {role!r}, which this sar-tui does not know."
            )
        return msgspec.convert(plain, Invitation)
    except (msgspec.MsgspecError, KeyError):
        raise _damaged(path) from None


def _damaged(path: Path) -> LinkError:
    return LinkError(f"The invitation {path} is damaged. Copy it again, or ask for a new one.")

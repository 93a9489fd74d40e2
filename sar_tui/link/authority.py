"""The certificate authority of a data folder: it vouches for the host, and for whoever was invited.

It lives in ``<data folder>/link``, open to this user alone, and is made with the first invitation. Its key never
leaves the folder. A guest's key leaves it in the invitation and is kept nowhere else.
"""

import contextlib
import os
import re
import secrets
from collections.abc import Iterable, Iterator, Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING

import filelock
import msgspec

from sar_tui.framework.messages import Role
from sar_tui.link.errors import LinkError, need_packages
from sar_tui.link.invitation import NAME, Invitation
from sar_tui.link.settings import Credentials, Endpoint, Guest, TlsFiles, parse_endpoint

if TYPE_CHECKING:
    from sar_tui.link import certificates

FOLDER = "link"
LONGEST_DAYS = 366
_AUTHORITY_DAYS = 20 * 365
_HOST_DAYS = 366
_RENEW_DAYS = 31
"""A host's certificate that would end sooner is made anew when a session begins."""
_PATIENCE_SECONDS = 5
_ALWAYS = ("localhost", "127.0.0.1", "::1")


class IssuedInvitation(msgspec.Struct, frozen=True, kw_only=True):
    """An invitation that was given out; ``fingerprint``: SHA-256 of its certificate. Times are UTC."""

    name: str
    role: Role
    endpoints: tuple[str, ...]
    fingerprint: str
    issued: datetime
    expires: datetime
    revoked: datetime | None = None

    @property
    def guest(self) -> Guest:
        return Guest(self.name, self.role)

    def state(self, now: datetime) -> str:
        """``good``, ``expired`` or ``revoked``."""
        if self.revoked is not None:
            return "revoked"
        return "expired" if self.expires <= now else "good"


class _Register(msgspec.Struct, frozen=True):
    link: str
    invitations: tuple[IssuedInvitation, ...] = ()


class Authority:
    """The authority of a data folder; use ``opened`` or ``made``."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._certificate = folder / "authority.pem"
        self._key = folder / "authority.key"
        self._register = folder / "invitations.json"

    @classmethod
    def exists(cls, data: Path) -> bool:
        """Whether anybody was ever invited."""
        return cls(data / FOLDER)._register.is_file()

    @classmethod
    def open(cls, data: Path) -> "Authority":
        """The authority that there is. Raises LinkError: there is none, or it cannot be read."""
        if not cls.exists(data):
            raise LinkError(
                "Nobody has been invited yet, so nobody could come over the network. "
                "First: sar-tui link invite operator --name NAME --host HOST"
            )
        authority = cls(data / FOLDER)
        authority._load()
        return authority

    @classmethod
    def open_or_create(cls, data: Path) -> "Authority":
        """The authority, made if there is none yet. Raises LinkError: it cannot be written or read."""
        authority = cls(data / FOLDER)
        with authority._alone():
            if not authority._register.is_file():
                authority._make()
        authority._load()
        return authority

    @property
    def link(self) -> str:
        """The id of the link over the network: the same for each session of this data folder."""
        return self._load().link

    @property
    def invitations(self) -> tuple[IssuedInvitation, ...]:
        """All that were given out, oldest first."""
        return self._load().invitations

    def guests(self, now: datetime | None = None) -> tuple[Guest, ...]:
        """Who may come: invited, not revoked, not expired."""
        at = now or datetime.now(UTC)
        return tuple(issued.guest for issued in self.invitations if issued.state(at) == "good")

    def invite(self, guest: Guest, where: Sequence[Endpoint], days: int, now: datetime | None = None) -> Invitation:
        """Make a certificate for somebody, and write down that it was made.

        Args:
            days: for how long it is good, 1 to 366.

        Raises:
            LinkError: the name cannot be one, or is taken, or no guest could come there. A name that was revoked stays
                taken until its certificate has expired: the certificate that was lost says the same name.
        """
        need_packages()
        from sar_tui.link import certificates

        at = (now or datetime.now(UTC)).replace(microsecond=0)
        if not re.fullmatch(NAME, guest.name):
            raise LinkError(
                f"{guest.name!r} cannot be a guest's name: letters, digits, - and _, at most 32, such as anna or lab-2."
            )
        if not 1 <= days <= LONGEST_DAYS:
            raise LinkError(f"An invitation is good for 1 to {LONGEST_DAYS} days, not {days}.")
        for end in where:
            if ":" in end.host:
                raise LinkError(
                    f"Nobody can be invited to {end.host}: zenoh does not connect to an IPv6 address by certificate. "
                    "Give this machine's name, or its IPv4 address."
                )
        expires = at + timedelta(days=days)
        with self._alone():
            register = self._load()
            for other in register.invitations:
                if other.name.casefold() == guest.name.casefold() and other.expires > at:
                    raise LinkError(_taken(other, at))
            own = self._own()
            made = certificates.guest(own, str(guest), at, expires)
            issued = IssuedInvitation(
                name=guest.name,
                role=guest.role,
                endpoints=tuple(str(end) for end in where),
                fingerprint=certificates.fingerprint(made.certificate),
                issued=at,
                expires=expires,
            )
            self._save(_Register(register.link, (*register.invitations, issued)))
        return Invitation(
            role=guest.role,
            name=guest.name,
            link=register.link,
            endpoints=issued.endpoints,
            expires=expires,
            credentials=Credentials(own.certificate, made.certificate, made.key),
        )

    def revoke(self, name: str, now: datetime | None = None) -> IssuedInvitation:
        """Let somebody in no longer, from the next session on. Raises LinkError: nobody of that name could come."""
        at = (now or datetime.now(UTC)).replace(microsecond=0)
        with self._alone():
            register = self._load()
            for number, issued in enumerate(register.invitations):
                if issued.name.casefold() == name.casefold() and issued.state(at) == "good":
                    revoked = msgspec.structs.replace(issued, revoked=at)
                    changed = (*register.invitations[:number], revoked, *register.invitations[number + 1 :])
                    self._save(_Register(register.link, changed))
                    return revoked
        good = ", ".join(guest.name for guest in self.guests(at))
        known = f"There is: {good}." if good else "There is no invitation that is good now."
        raise LinkError(f"There is no invitation for {name} that could be revoked. {known}")

    def forget(self, guest: Guest) -> None:
        """Strike out the latest invitation of somebody: its file could not be written, so nobody has it."""
        with self._alone():
            register = self._load()
            kept = list(register.invitations)
            for number in reversed(range(len(kept))):
                if kept[number].guest == guest:
                    del kept[number]
                    break
            self._save(_Register(register.link, tuple(kept)))

    def host_files(self, listen: Iterable[Endpoint], now: datetime | None = None) -> TlsFiles:
        """A host's certificate for the names that it is invited to and listens under, made anew where need be.

        Raises LinkError: it cannot be written.
        """
        need_packages()
        from sar_tui.link import certificates

        at = (now or datetime.now(UTC)).replace(microsecond=0)
        files = TlsFiles(self._certificate, self._folder / "host.pem", self._folder / "host.key")
        invited = (parse_endpoint(text).host for issued in self.invitations for text in issued.endpoints)
        names = list(dict.fromkeys([*_ALWAYS, *invited, *(end.host for end in listen)]))
        with self._alone():
            own = self._own()
            try:
                held = certificates.Pair(files.certificate.read_text(), files.key.read_text())
            except (OSError, ValueError):
                held = None
            soon = at + timedelta(days=_RENEW_DAYS)
            if held is None or not certificates.serves(held, own.certificate, names, soon):
                made = certificates.host(own, names, at, _HOST_DAYS)
                self._put(files.key, made.key)
                self._put(files.certificate, made.certificate)
        return files

    def _make(self) -> None:
        need_packages()
        from sar_tui.link import certificates

        link = secrets.token_hex(6)
        at = datetime.now(UTC).replace(microsecond=0)
        own = certificates.authority(f"sar-tui link {link}", at, _AUTHORITY_DAYS)
        self._put(self._key, own.key)
        self._put(self._certificate, own.certificate)
        self._save(_Register(link))

    def _own(self) -> "certificates.Pair":
        from sar_tui.link import certificates

        try:
            own = certificates.Pair(self._certificate.read_text(), self._key.read_text())
        except (OSError, ValueError):
            raise self._damaged() from None
        if not certificates.fits(own):
            raise self._damaged()
        return own

    def _load(self) -> _Register:
        try:
            return msgspec.json.decode(self._register.read_bytes(), type=_Register)
        except (OSError, msgspec.MsgspecError):
            raise self._damaged() from None

    def _save(self, register: _Register) -> None:
        self._put(self._register, msgspec.json.format(msgspec.json.encode(register), indent=1).decode() + "\n")

    def _put(self, path: Path, text: str) -> None:
        """Write a file that is there whole or not at all, readable to this user alone."""
        half = path.with_name(f"{path.name}.{secrets.token_hex(4)}")
        try:
            with os.fdopen(os.open(half, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
            half.replace(path)
        except OSError as error:
            with contextlib.suppress(OSError):
                half.unlink()
            raise self._unwritable(error) from None

    @contextlib.contextmanager
    def _alone(self) -> Iterator[None]:
        """One program at a time."""
        try:
            self._folder.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            self._folder.mkdir(exist_ok=True, mode=0o700)
            if os.name == "posix":
                self._folder.chmod(0o700)
            lock = filelock.FileLock(self._folder / "lock", timeout=_PATIENCE_SECONDS, mode=0o600)
            lock.acquire()
        except filelock.Timeout:
            raise LinkError(f"Another program is at work in {self._folder}. Try again in a moment.") from None
        except OSError as error:
            raise self._unwritable(error) from None
        try:
            yield
        finally:
            lock.release()

    def _unwritable(self, error: OSError) -> LinkError:
        return LinkError(f"{self._folder} cannot be written to: {error.strerror}.")

    def _damaged(self) -> LinkError:
        return LinkError(
            f"What certificates are made with, in {self._folder}, is damaged or cannot be read. Restore that folder "
            "from a backup; or move it away, and invite everybody anew."
        )


def _taken(other: IssuedInvitation, at: datetime) -> str:
    if other.state(at) == "revoked":
        return (
            f"The name {other.name} was revoked, and stays taken until {other.expires:%Y-%m-%d}: the invitation that "
            f"was revoked says the same name. Choose another, such as {other.name[:30]}-2."
        )
    return (
        f"{other.name} has an invitation already, as {other.role}, good until {other.expires:%Y-%m-%d}. Choose another "
        f"name, or revoke that one: sar-tui link revoke {other.name}"
    )

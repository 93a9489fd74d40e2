"""Certificate authority of a data folder: it issues the host's certificate and those of invited
guests.

Its files are in ``<data folder>/link``, private to this user, and are created with the first
invitation. Its key never leaves the folder. A guest's key is written to the invitation only.
"""

import contextlib
import os
import secrets
from collections.abc import Iterable, Iterator, Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING

import filelock
import msgspec

from sar_tui.drivers.files import make_private
from sar_tui.link.errors import LinkError, need_packages
from sar_tui.link.invitation import FOLDER, Invitation, check_name
from sar_tui.link.zenoh_settings import (
    Credentials,
    Endpoint,
    Guest,
    InvitedAs,
    TlsFiles,
    parse_endpoint,
)

if TYPE_CHECKING:
    from sar_tui.link import certificates

MAX_DAYS = 366
_AUTHORITY_DAYS = 20 * 365
_HOST_DAYS = 366
_RENEW_DAYS = 31
"""A host's certificate that expires sooner is renewed when a session starts."""
_LOCK_TIMEOUT_S = 5
_LOCAL_NAMES = ("localhost", "127.0.0.1", "::1")


class IssuedInvitation(msgspec.Struct, frozen=True, kw_only=True):
    """Register entry of an invitation; ``fingerprint``: SHA-256 of its certificate. Times are
    UTC.
    """

    name: str
    role: InvitedAs
    endpoints: tuple[str, ...]
    fingerprint: str
    issued: datetime
    expires: datetime
    revoked: datetime | None = None

    @property
    def guest(self) -> Guest:
        return Guest(self.name, self.role)

    def state(self, now: datetime) -> str:
        """Return ``good``, ``expired`` or ``revoked``."""
        if self.revoked is not None:
            return "revoked"
        return "expired" if self.expires <= now else "good"


class _Register(msgspec.Struct, frozen=True):
    link: str
    invitations: tuple[IssuedInvitation, ...] = ()


class Authority:
    """Certificate authority of a data folder; use ``open`` or ``open_or_create``."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._certificate = folder / "authority.pem"
        self._key = folder / "authority.key"
        self._register = folder / "invitations.json"

    @classmethod
    def exists(cls, data: Path) -> bool:
        """Return whether the data folder has an authority."""
        return cls(data / FOLDER)._register.is_file()

    @classmethod
    def open(cls, data: Path) -> "Authority":
        """Open the authority. Raises LinkError if there is none or it cannot be read."""
        if not cls.exists(data):
            raise LinkError(
                "Nobody has been invited yet, so nobody could join over the network. "
                "First: sar-tui link invite operator --name NAME --host HOST"
            )
        authority = cls(data / FOLDER)
        authority._load()
        return authority

    @classmethod
    def open_or_create(cls, data: Path) -> "Authority":
        """Open the authority, and create it if needed. Raises LinkError if it cannot be written or
        read.
        """
        authority = cls(data / FOLDER)
        with authority._locked():
            if not authority._register.is_file():
                authority._create()
        authority._load()
        return authority

    @property
    def link(self) -> str:
        """Id of the link over the network, the same for all sessions of this data folder."""
        return self._load().link

    @property
    def invitations(self) -> tuple[IssuedInvitation, ...]:
        """All invitations, oldest first."""
        return self._load().invitations

    def guests(self, now: datetime | None = None) -> tuple[Guest, ...]:
        """Return the guests whose invitations are neither revoked nor expired."""
        at = now or datetime.now(UTC)
        return tuple(issued.guest for issued in self.invitations if issued.state(at) == "good")

    def invite(
        self,
        guest: Guest,
        where: Sequence[Endpoint],
        days: int,
        now: datetime | None = None,
        *,
        router: bool = False,
    ) -> Invitation:
        """Issue a certificate for a guest and register it.

        Args:
            days: its validity in days, 1 to 366.
            router: the endpoints are those of the clinic's router; always so for a home.

        Raises:
            LinkError: the name is invalid or taken, or an endpoint cannot be used. A revoked name
                stays taken until its certificate expires, as the revoked certificate has the same
                name.
        """
        need_packages()
        from sar_tui.link import certificates

        at = (now or datetime.now(UTC)).replace(microsecond=0)
        check_name(guest.name)
        if not 1 <= days <= MAX_DAYS:
            raise LinkError(f"An invitation is valid for 1 to {MAX_DAYS} days, not {days}.")
        for end in where:
            if ":" in end.host:
                raise LinkError(
                    f"Nobody can be invited to {end.host}: zenoh does not connect to an IPv6 "
                    "address by certificate. "
                    "Give this machine's name, or its IPv4 address."
                )
        expires = at + timedelta(days=days)
        with self._locked():
            register = self._load()
            for other in register.invitations:
                if other.name.casefold() == guest.name.casefold() and other.expires > at:
                    raise LinkError(_taken(other, at))
            own = self._load_pair()
            pair = certificates.issue_guest(own, str(guest), at, expires)
            issued = IssuedInvitation(
                name=guest.name,
                role=guest.role,
                endpoints=tuple(str(end) for end in where),
                fingerprint=certificates.fingerprint(pair.certificate),
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
            router=router or guest.role == "home",
            credentials=Credentials(own.certificate, pair.certificate, pair.key),
        )

    def revoke(self, name: str, now: datetime | None = None) -> IssuedInvitation:
        """Revoke an invitation from the next session on. Raises LinkError if there is no valid one
        of that name.
        """
        at = (now or datetime.now(UTC)).replace(microsecond=0)
        with self._locked():
            register = self._load()
            for number, issued in enumerate(register.invitations):
                if issued.name.casefold() == name.casefold() and issued.state(at) == "good":
                    revoked = msgspec.structs.replace(issued, revoked=at)
                    changed = (
                        *register.invitations[:number],
                        revoked,
                        *register.invitations[number + 1 :],
                    )
                    self._save(_Register(register.link, changed))
                    return revoked
        names = ", ".join(guest.name for guest in self.guests(at))
        known = f"Valid invitations: {names}." if names else "No invitation is valid now."
        raise LinkError(f"There is no valid invitation for {name}. {known}")

    def forget(self, guest: Guest) -> None:
        """Remove the latest invitation of a guest from the register, as its file could not be
        written.
        """
        with self._locked():
            register = self._load()
            invitations = list(register.invitations)
            for number in reversed(range(len(invitations))):
                if invitations[number].guest == guest:
                    del invitations[number]
                    break
            self._save(_Register(register.link, tuple(invitations)))

    def host_files(self, listen: Iterable[Endpoint], now: datetime | None = None) -> TlsFiles:
        """Return the host's certificate for all names in invitations and in ``listen``, renewed if
        needed.

        Raises LinkError if it cannot be written.
        """
        need_packages()
        from sar_tui.link import certificates

        at = (now or datetime.now(UTC)).replace(microsecond=0)
        files = TlsFiles(self._certificate, self._folder / "host.pem", self._folder / "host.key")
        invited = (
            parse_endpoint(text).host for issued in self.invitations for text in issued.endpoints
        )
        names = list(dict.fromkeys([*_LOCAL_NAMES, *invited, *(end.host for end in listen)]))
        with self._locked():
            own = self._load_pair()
            try:
                pair = certificates.CertificatePair(
                    files.certificate.read_text(), files.key.read_text()
                )
            except (OSError, ValueError):
                pair = None
            soon = at + timedelta(days=_RENEW_DAYS)
            if pair is None or not certificates.is_valid_for_host(
                pair, own.certificate, names, soon
            ):
                issued = certificates.issue_host(own, names, at, _HOST_DAYS)
                self._write(files.key, issued.key)
                self._write(files.certificate, issued.certificate)
        return files

    def _create(self) -> None:
        need_packages()
        from sar_tui.link import certificates

        link = secrets.token_hex(6)
        at = datetime.now(UTC).replace(microsecond=0)
        own = certificates.create_authority(f"sar-tui link {link}", at, _AUTHORITY_DAYS)
        self._write(self._key, own.key)
        self._write(self._certificate, own.certificate)
        self._save(_Register(link))

    def _load_pair(self) -> "certificates.CertificatePair":
        from sar_tui.link import certificates

        try:
            own = certificates.CertificatePair(self._certificate.read_text(), self._key.read_text())
        except (OSError, ValueError):
            raise self._damaged() from None
        if not certificates.is_pair(own):
            raise self._damaged()
        return own

    def _load(self) -> _Register:
        try:
            return msgspec.json.decode(self._register.read_bytes(), type=_Register)
        except (OSError, msgspec.MsgspecError):
            raise self._damaged() from None

    def _save(self, register: _Register) -> None:
        self._write(
            self._register,
            msgspec.json.format(msgspec.json.encode(register), indent=1).decode() + "\n",
        )

    def _write(self, path: Path, text: str) -> None:
        """Write a file atomically, readable only by this user."""
        temporary = path.with_name(f"{path.name}.{secrets.token_hex(4)}")
        try:
            with os.fdopen(
                os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w"
            ) as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
            temporary.replace(path)
        except OSError as error:
            with contextlib.suppress(OSError):
                temporary.unlink()
            raise self._unwritable(error) from None

    @contextlib.contextmanager
    def _locked(self) -> Iterator[None]:
        """Hold the folder's lock, so that one program at a time changes it."""
        try:
            make_private(self._folder)
            if os.name == "posix":
                self._folder.chmod(0o700)
            lock = filelock.FileLock(self._folder / "lock", timeout=_LOCK_TIMEOUT_S, mode=0o600)
            lock.acquire()
        except filelock.Timeout:
            raise LinkError(
                f"Another program is using {self._folder}. Try again in a moment."
            ) from None
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
            f"The certificate authority in {self._folder} is damaged or cannot be read. Restore "
            "that folder from a "
            "backup; or move it away, and make all invitations again."
        )


def _taken(other: IssuedInvitation, at: datetime) -> str:
    if other.state(at) == "revoked":
        return (
            f"The name {other.name} was revoked and stays taken until {other.expires:%Y-%m-%d}, "
            "as the revoked "
            f"invitation has the same name. Choose another, such as {other.name[:30]}-2."
        )
    return (
        f"{other.name} already has an invitation, as {other.role}, valid until "
        f"{other.expires:%Y-%m-%d}. Choose "
        f"another name, or revoke that one: sar-tui link revoke {other.name}"
    )

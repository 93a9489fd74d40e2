"""Certificate authority of a data folder."""

import stat
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from cryptography import x509

from sar_tui.link.authority import Authority
from sar_tui.link.errors import LinkError
from sar_tui.link.zenoh_settings import Endpoint, Guest

HERE = Endpoint("lab-pc.local", 7447)
NOW = datetime(2026, 3, 1, 12, tzinfo=UTC)
ANNA = Guest("anna", "operator")
EVE = Guest("eve", "observer")


@pytest.fixture
def authority(data: Path) -> Authority:
    return Authority.open_or_create(data)


def names_of(certificate: Path) -> list[str]:
    read = x509.load_pem_x509_certificate(certificate.read_bytes())
    names = read.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    return [str(name.value) for name in names]


def test_authority_is_created_once(data: Path) -> None:
    first = Authority.open_or_create(data).invite(ANNA, [HERE], 30)
    second = Authority.open_or_create(data).invite(EVE, [HERE], 30)
    assert first.credentials.authority == second.credentials.authority
    assert first.link == second.link == Authority.open(data).link


def test_without_invitation_there_is_no_authority(data: Path) -> None:
    assert not Authority.exists(data)
    with pytest.raises(LinkError, match="link invite"):
        Authority.open(data)


def test_folder_and_files_are_private(authority: Authority, data: Path) -> None:
    authority.invite(ANNA, [HERE], 30)
    authority.host_files([HERE])
    assert stat.S_IMODE(data.stat().st_mode) == 0o700
    assert stat.S_IMODE((data / "link").stat().st_mode) == 0o700
    files = list((data / "link").iterdir())
    assert len(files) >= 5
    assert {stat.S_IMODE(path.stat().st_mode) for path in files} == {0o600}


def test_guest_key_is_only_in_the_invitation(authority: Authority, data: Path) -> None:
    key = authority.invite(ANNA, [HERE], 30).credentials.key
    assert all(key.splitlines()[1] not in path.read_text() for path in (data / "link").iterdir())


def test_invitation_expires_with_its_certificate(authority: Authority) -> None:
    invitation = authority.invite(ANNA, [HERE], 30, NOW)
    certificate = x509.load_pem_x509_certificate(invitation.credentials.certificate.encode())
    assert invitation.expires == certificate.not_valid_after_utc == NOW + timedelta(days=30)
    assert certificate.subject.rfc4514_string() == "CN=operator.anna"


def test_expired_and_revoked_guests_are_not_admitted(authority: Authority) -> None:
    authority.invite(ANNA, [HERE], 30, NOW)
    authority.invite(EVE, [HERE], 10, NOW)
    authority.invite(Guest("ben", "operator"), [HERE], 30, NOW)
    authority.revoke("ben", NOW)
    assert authority.guests(NOW) == (ANNA, EVE)
    assert authority.guests(NOW + timedelta(days=20)) == (ANNA,)
    later = NOW + timedelta(days=20)
    assert [issued.state(later) for issued in authority.invitations] == [
        "good",
        "expired",
        "revoked",
    ]


def test_name_is_taken_while_its_certificate_is_valid_even_if_revoked(
    authority: Authority,
) -> None:
    authority.invite(ANNA, [HERE], 30, NOW)
    with pytest.raises(LinkError, match="revoke anna"):
        authority.invite(Guest("Anna", "observer"), [HERE], 30, NOW)
    authority.revoke("anna", NOW)
    with pytest.raises(LinkError, match="anna-2"):
        authority.invite(ANNA, [HERE], 30, NOW + timedelta(days=29))
    assert authority.invite(ANNA, [HERE], 30, NOW + timedelta(days=30)).guest == ANNA


def test_forgotten_invitation_frees_its_name(authority: Authority) -> None:
    authority.invite(ANNA, [HERE], 30)
    authority.forget(ANNA)
    assert authority.guests() == ()
    authority.invite(ANNA, [HERE], 30)


def test_revoking_an_unknown_guest_is_refused(authority: Authority) -> None:
    authority.invite(ANNA, [HERE], 30)
    with pytest.raises(LinkError, match="Valid invitations: anna"):
        authority.revoke("ben")


@pytest.mark.parametrize(
    ("guest", "where", "days", "why"),
    [
        *(
            (Guest(name, "operator"), HERE, 30, "cannot be a guest's name")
            for name in ("", "anna b", "a/b", "a*", "anna.b", "-anna", "x" * 33, "änna", "anna\n")
        ),
        (ANNA, Endpoint("fe80::1", 7447), 30, "IPv4"),
        *((ANNA, HERE, days, "1 to 366 days") for days in (0, -1, 367)),
    ],
)
def test_an_invitation_that_cannot_be_is_refused(
    authority: Authority, guest: Guest, where: Endpoint, days: int, why: str
) -> None:
    with pytest.raises(LinkError, match=why):
        authority.invite(guest, [HERE, where], days)
    assert authority.guests() == ()


# --- the host's own certificate


def test_host_certificate_names_all_endpoints(authority: Authority) -> None:
    authority.invite(ANNA, [HERE, Endpoint("192.168.1.20", 7000)], 30)
    files = authority.host_files([Endpoint("10.0.0.5", 7447)])
    expected = {"localhost", "127.0.0.1", "::1", "lab-pc.local", "192.168.1.20", "10.0.0.5"}
    assert set(names_of(files.certificate)) == expected


def test_host_certificate_is_renewed_only_when_needed(authority: Authority) -> None:
    files = authority.host_files([HERE], NOW)
    first = files.certificate.read_text()
    authority.host_files([HERE], NOW + timedelta(days=300))
    assert files.certificate.read_text() == first
    authority.host_files([HERE], NOW + timedelta(days=350))
    second = files.certificate.read_text()
    assert second != first
    authority.host_files([Endpoint("elsewhere", 7447)], NOW + timedelta(days=350))
    assert files.certificate.read_text() != second


@pytest.mark.parametrize("spoil", [Path.unlink, lambda path: path.write_text("no key")])
def test_lost_host_key_is_replaced(authority: Authority, spoil: Callable[[Path], object]) -> None:
    files = authority.host_files([HERE])
    spoil(files.key)
    authority.host_files([HERE])
    assert "PRIVATE KEY" in files.key.read_text()


# --- faults


@pytest.mark.parametrize("name", ["authority.pem", "authority.key", "invitations.json"])
@pytest.mark.parametrize("spoil", [Path.unlink, lambda path: path.write_text("{}")])
def test_damaged_authority_is_reported_and_left_unchanged(
    authority: Authority, data: Path, name: str, spoil: Callable[[Path], object]
) -> None:
    authority.invite(ANNA, [HERE], 30)
    spoil(data / "link" / name)
    before = {path.name: path.read_bytes() for path in (data / "link").iterdir()}
    with pytest.raises(LinkError, match=r"damaged|Nobody has been invited"):
        Authority.open(data).invite(EVE, [HERE], 30)
    assert {path.name: path.read_bytes() for path in (data / "link").iterdir()} == before


def test_unwritable_folder_is_reported(data: Path) -> None:
    data.write_text("a file where the data folder should be")
    with pytest.raises(LinkError, match="cannot be written to"):
        Authority.open_or_create(data)

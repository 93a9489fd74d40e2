"""Invitation files: writing, and validation on reading."""

import json
import stat
from collections.abc import Callable
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest

from sar_tui.link.authority import Authority
from sar_tui.link.errors import LinkError
from sar_tui.link.invitation import Invitation, file_name, read, write
from sar_tui.link.zenoh_settings import Endpoint, Guest

HERE = Endpoint("lab-pc.local", 7000)


@pytest.fixture(scope="module")
def authority(tmp_path_factory: pytest.TempPathFactory) -> Authority:
    return Authority.open_or_create(tmp_path_factory.mktemp("data"))


@pytest.fixture(scope="module")
def anna(authority: Authority) -> Invitation:
    return authority.invite(Guest("anna", "operator"), [HERE, Endpoint("10.0.0.5", 7447)], 30)


@pytest.fixture(scope="module")
def eve(authority: Authority) -> Invitation:
    return authority.invite(Guest("eve", "observer"), [HERE], 30)


@pytest.fixture
def path(anna: Invitation, tmp_path: Path) -> Path:
    write(anna, tmp_path / "anna.sar-link")
    return tmp_path / "anna.sar-link"


def changed(path: Path, change: Callable[[dict[str, Any]], object]) -> Path:
    plain = json.loads(path.read_text())
    change(plain)
    path.write_text(json.dumps(plain))
    return path


def test_a_file_is_read_as_it_was_written_and_is_private_and_named_after_the_guest(
    anna: Invitation, path: Path
) -> None:
    assert read(path) == anna
    assert read(path).where == (HERE, Endpoint("10.0.0.5", 7447))
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert file_name(anna.guest) == "operator-anna.sar-link"
    assert "PRIVATE" not in f"{anna!r} {anna}"


def test_a_file_that_exists_is_left_as_it_is_and_an_unwritable_one_reported(
    anna: Invitation, tmp_path: Path
) -> None:
    taken = tmp_path / "taken.sar-link"
    taken.write_text("mine")
    with pytest.raises(LinkError, match="already exists"):
        write(anna, taken)
    assert taken.read_text() == "mine"
    with pytest.raises(LinkError, match="cannot be created"):
        write(anna, tmp_path / "no" / "folder.sar-link")


# --- reading


def test_what_is_no_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(LinkError, match="There is no file"):
        read(tmp_path / "none.sar-link")
    with pytest.raises(LinkError, match="cannot be read"):
        read(tmp_path)


@pytest.mark.parametrize(
    "content", [b"", b"hello", b"\xff\xfe\x00", b'{"format": "another"}', b"x" * 100_000]
)
def test_another_file_is_not_an_invitation(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "x.sar-link").write_bytes(content)
    with pytest.raises(LinkError, match="is not an invitation"):
        read(tmp_path / "x.sar-link")


def test_an_invitation_that_was_cut_off_is_damaged(path: Path) -> None:
    whole = path.read_bytes()
    for length in range(100, len(whole) - 2, 97):
        path.write_bytes(whole[:length])
        with pytest.raises(LinkError, match="is damaged"):
            read(path)


@pytest.mark.parametrize(
    "change",
    [
        lambda plain: plain.pop("credentials"),
        lambda plain: plain.pop("version"),
        lambda plain: plain.update(endpoints=[]),
        lambda plain: plain.update(endpoints=["not a place"]),
        lambda plain: plain.update(name="../anna"),
        lambda plain: plain.update(link="*"),
        lambda plain: plain["credentials"].update(key="none"),
        lambda plain: plain["credentials"].update(certificate=plain["credentials"]["authority"]),
    ],
)
def test_invalid_field_is_reported_as_damage(
    path: Path, change: Callable[[dict[str, Any]], object]
) -> None:
    with pytest.raises(LinkError, match="is damaged"):
        read(changed(path, change))


def test_neither_role_nor_key_can_be_changed(path: Path, eve: Invitation, tmp_path: Path) -> None:
    write(eve, tmp_path / "eve.sar-link")
    for changes in (
        changed(tmp_path / "eve.sar-link", lambda plain: plain.update(role="operator")),
        changed(path, lambda plain: plain["credentials"].update(key=eve.credentials.key)),
    ):
        with pytest.raises(LinkError, match="is damaged"):
            read(changes)


def test_an_invitation_of_a_newer_version_asks_for_an_update_and_an_unknown_role_is_named(
    path: Path,
) -> None:
    with pytest.raises(LinkError, match="role 'conductor'"):
        read(changed(path, lambda plain: plain.update(role="conductor")))
    with pytest.raises(LinkError, match="newer sar-tui"):
        read(changed(path, lambda plain: plain.update(version=2)))


def test_an_expired_invitation_says_when_its_certificate_expired(
    anna: Invitation, path: Path
) -> None:
    changed(path, lambda plain: plain.update(expires="2099-01-01T00:00:00Z"))
    with pytest.raises(LinkError, match=f"expired on {anna.expires:%Y-%m-%d at %H:%M} UTC"):
        read(path, anna.expires)
    assert read(path, anna.expires - timedelta(seconds=1)).expires == anna.expires

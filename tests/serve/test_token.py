"""Given a token, when it is kept, then nobody else reads it, and what is none is not taken for one."""

import os
import stat
from pathlib import Path

import pytest

from sar_tui.serve.token import TokenError, load_or_create_token, new_token


def test_no_token_comes_twice() -> None:
    assert new_token() != new_token()
    assert len(new_token()) >= 43


def test_a_kept_token_is_the_same_again_and_its_owners_alone(tmp_path: Path) -> None:
    file = tmp_path / "token"
    token = load_or_create_token(file)
    assert load_or_create_token(file) == token
    assert stat.S_IMODE(file.stat().st_mode) == 0o600


def test_a_file_that_others_may_read_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "token"
    load_or_create_token(file)
    file.chmod(0o640)
    with pytest.raises(TokenError, match="Other users can read"):
        load_or_create_token(file)


@pytest.mark.parametrize("held", [b"", b"short", b"with spaces and more than enough", b"\xff" * 40, b"x" * 30 + b"?"])
def test_a_file_without_a_token_is_refused(tmp_path: Path, held: bytes) -> None:
    file = tmp_path / "token"
    file.write_bytes(held)
    file.chmod(0o600)
    with pytest.raises(TokenError, match="contains no token"):
        load_or_create_token(file)


def test_a_place_where_none_can_be_kept_is_told(tmp_path: Path) -> None:
    with pytest.raises(TokenError, match="cannot be created"):
        load_or_create_token(tmp_path / "nowhere" / "token")
    os.mkdir(tmp_path / "folder")
    with pytest.raises(TokenError, match="cannot be read"):
        load_or_create_token(tmp_path / "folder")

"""Token files are private and validated."""

import os
import stat
from pathlib import Path

import pytest

from sar_tui.serve.guard import TokenError, load_or_create_token, new_token


def test_tokens_are_random() -> None:
    assert new_token() != new_token()
    assert len(new_token()) >= 43


def test_stored_token_is_reused_and_private(tmp_path: Path) -> None:
    file = tmp_path / "token"
    token = load_or_create_token(file)
    assert load_or_create_token(file) == token
    assert stat.S_IMODE(file.stat().st_mode) == 0o600


def test_file_readable_by_others_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "token"
    load_or_create_token(file)
    file.chmod(0o640)
    with pytest.raises(TokenError, match="Other users can read"):
        load_or_create_token(file)


@pytest.mark.parametrize(
    "held", [b"", b"short", b"with spaces and more than enough", b"\xff" * 40, b"x" * 30 + b"?"]
)
def test_a_file_without_a_token_is_refused(tmp_path: Path, held: bytes) -> None:
    file = tmp_path / "token"
    file.write_bytes(held)
    file.chmod(0o600)
    with pytest.raises(TokenError, match="contains no token"):
        load_or_create_token(file)


def test_unusable_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(TokenError, match="cannot be created"):
        load_or_create_token(tmp_path / "nowhere" / "token")
    os.mkdir(tmp_path / "folder")
    with pytest.raises(TokenError, match="cannot be read"):
        load_or_create_token(tmp_path / "folder")

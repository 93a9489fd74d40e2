"""Access control: wrong tokens are refused, and delayed by client address; their files are private."""

import os
import stat
from pathlib import Path

import pytest

from sar_tui.serve.address import Address
from sar_tui.serve.guard import (
    WRONG_TOKEN,
    AccessRequest,
    Guard,
    TokenError,
    WrongTokenDelay,
    load_or_create_token,
    new_token,
)


def test_later_wrong_tokens_are_delayed_for_a_minute() -> None:
    seconds = [0.0]
    delay = WrongTokenDelay(lambda: seconds[0])
    assert [delay.next_delay("10.0.0.1") for _ in range(20)] == [0] * 5 + [*range(1, 10)] + [10] * 6
    assert delay.next_delay("10.0.0.2") == 0
    seconds[0] = 61
    assert delay.next_delay("10.0.0.1") == 0


def test_number_of_remembered_addresses_is_limited() -> None:
    delay = WrongTokenDelay(lambda: 0.0)
    for _ in range(6):
        delay.next_delay("10.0.0.1")
    for number in range(1000):
        delay.next_delay(f"10.1.{number // 256}.{number % 256}")
    assert delay.next_delay("10.0.0.1") == 0


def test_wrong_token_or_cookie_is_refused_whatever_its_characters() -> None:
    guard = Guard(Address("127.0.0.1", 8000), "right")
    request = AccessRequest("127.0.0.1:8000", None, None, "", False)
    for wrong in ("", "righ", "rightt", "ríght", "right\0"):
        assert guard.check(request._replace(token=wrong, cookie=guard.cookie)) is WRONG_TOKEN
    for wrong in ("ñ", b"\xff".decode(errors="surrogateescape")):
        assert guard.check(request._replace(cookie=wrong)) is WRONG_TOKEN
    assert guard.check(request._replace(token="right")) is None
    assert guard.check(request._replace(cookie=guard.cookie)) is None


# --- the token's file


def test_tokens_are_random() -> None:
    assert new_token() != new_token()
    assert len(new_token()) >= 43


def test_stored_token_is_reused_and_private_and_refused_if_others_can_read_it(
    tmp_path: Path,
) -> None:
    file = tmp_path / "token"
    token = load_or_create_token(file)
    assert load_or_create_token(file) == token
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
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

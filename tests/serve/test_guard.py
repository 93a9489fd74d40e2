"""Access control: wrong tokens are refused, and delayed by client address."""

from sar_tui.serve.address import Address
from sar_tui.serve.guard import WRONG_TOKEN, AccessRequest, Guard, WrongTokenDelay


def test_later_wrong_tokens_are_delayed() -> None:
    delay = WrongTokenDelay(lambda: 0.0)
    assert [delay.next_delay("10.0.0.1") for _ in range(20)] == [0] * 5 + [*range(1, 10)] + [10] * 6
    assert delay.next_delay("10.0.0.2") == 0


def test_delay_is_forgotten_after_a_minute() -> None:
    seconds = [0.0]
    delay = WrongTokenDelay(lambda: seconds[0])
    for _ in range(8):
        delay.next_delay("10.0.0.1")
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

"""Who may in: the token, the names this place is called by, and the pages that may speak to it."""

import hmac
from collections import OrderedDict, deque
from collections.abc import Callable
from hashlib import sha256
from typing import NamedTuple

from sar_tui.serve.address import Address

_PATIENCE = 5
"""So many wrong tokens from one address within a minute are answered at once; each further one later."""
_WINDOW_S = 60.0
_SLOWEST_S = 10.0
_REMEMBERED = 1000
"""Addresses whose wrong tokens are remembered."""


class AccessRequest(NamedTuple):
    """What a request says of itself. ``token``: of its URL, None without; ``cookie``: what it brought of ours."""

    host: str
    origin: str | None
    token: str | None
    cookie: str
    is_websocket: bool


class Refusal(NamedTuple):
    """Why a request is refused, in one plain sentence, and in a few words for the log."""

    sentence: str
    told: str
    is_wrong_token: bool = False


FOREIGN_HOST = Refusal(
    "This is not a name that sar-tui is served under; use the address that `sar-tui serve` printed.", "another host"
)
FOREIGN_PAGE = Refusal("Another page may not look into this one.", "another origin")
NO_TOKEN = Refusal("This needs the whole address that `sar-tui serve` printed, with its token.", "no token")
WRONG_TOKEN = Refusal(
    "This token is not the right one; use the address that `sar-tui serve` printed.", "a wrong token", True
)


class Guard:
    """Judges requests.

    Args:
        address: where the views are served.
        token: what opens them.
    """

    def __init__(self, address: Address, token: str) -> None:
        self._address = address
        self._token = token.encode()
        self.cookie = hmac.new(self._token, b"sar-tui cookie", sha256).hexdigest()
        """What a browser that has shown the token is known by; it does not tell the token."""

    def check(self, asked: AccessRequest) -> Refusal | None:
        """Why a request may not in; None if it may."""
        if not self._address.allows_host(asked.host):
            return FOREIGN_HOST
        if asked.origin is None:
            if asked.is_websocket:
                return FOREIGN_PAGE
        elif not self._address.allows_origin(asked.origin, asked.host):
            return FOREIGN_PAGE
        if asked.token is not None:
            return None if _is_same(asked.token, self._token) else WRONG_TOKEN
        if asked.cookie:
            return None if _is_same(asked.cookie, self.cookie.encode()) else WRONG_TOKEN
        return NO_TOKEN


def _is_same(shown: str, secret: bytes) -> bool:
    """In the same time whether it is nearly right or not. Bytes that are no text come as lone surrogates."""
    return hmac.compare_digest(shown.encode(errors="surrogatepass"), secret)


class WrongTokenDelay:
    """How long the answer to a wrong token is put off, by the address it came from.

    Args:
        now: a clock, in seconds.
    """

    def __init__(self, now: Callable[[], float]) -> None:
        self._now = now
        self._wrong: OrderedDict[str, deque[float]] = OrderedDict()

    def wrong(self, remote: str) -> float:
        """A wrong token came from there: the seconds to wait before it is answered."""
        now = self._now()
        times = self._wrong.setdefault(remote, deque(maxlen=100))
        self._wrong.move_to_end(remote)
        while len(self._wrong) > _REMEMBERED:
            self._wrong.popitem(last=False)
        while times and now - times[0] > _WINDOW_S:
            times.popleft()
        times.append(now)
        return min(_SLOWEST_S, max(0.0, float(len(times) - _PATIENCE)))

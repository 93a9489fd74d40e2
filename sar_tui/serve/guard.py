"""Access control: the token or its cookie, the host name, and the origin of a request."""

import hmac
from collections import OrderedDict, deque
from collections.abc import Callable
from hashlib import sha256
from typing import NamedTuple

from sar_tui.serve.address import Address

_FREE_ATTEMPTS = 5
"""Wrong tokens per client address and minute that are answered without delay."""
_WINDOW_S = 60.0
_MAX_DELAY_S = 10.0
_MAX_ADDRESSES = 1000


class AccessRequest(NamedTuple):
    """Parts of a request that decide on access. ``token``: from its URL; ``cookie``: ours, or
    empty.
    """

    host: str
    origin: str | None
    token: str | None
    cookie: str
    is_websocket: bool


class Refusal(NamedTuple):
    """Reason why a request is refused: a sentence for the browser, and a few words for the log."""

    sentence: str
    log_text: str
    is_wrong_token: bool = False


FOREIGN_HOST = Refusal(
    "This is not a name that sar-tui is served under; use the address that `sar-tui serve` "
    "printed.",
    "another host",
)
FOREIGN_PAGE = Refusal("Other pages may not connect to this one.", "another origin")
NO_TOKEN = Refusal(
    "Open the complete address that `sar-tui serve` printed, with its token.", "no token"
)
WRONG_TOKEN = Refusal(
    "This token is wrong; use the address that `sar-tui serve` printed.", "a wrong token", True
)


class Guard:
    """Access control for requests.

    Args:
        address: where the views are served.
        token: the secret that opens them.
    """

    def __init__(self, address: Address, token: str) -> None:
        self._address = address
        self._token = token.encode()
        self.cookie = hmac.new(self._token, b"sar-tui cookie", sha256).hexdigest()
        """Identifies a browser that has shown the token; the token cannot be derived from it."""

    def check(self, request: AccessRequest) -> Refusal | None:
        """Return why a request is refused, or None if it is allowed."""
        if not self._address.allows_host(request.host):
            return FOREIGN_HOST
        if request.origin is None:
            if request.is_websocket:
                return FOREIGN_PAGE
        elif not self._address.allows_origin(request.origin, request.host):
            return FOREIGN_PAGE
        if request.token is not None:
            return None if _is_same(request.token, self._token) else WRONG_TOKEN
        if request.cookie:
            return None if _is_same(request.cookie, self.cookie.encode()) else WRONG_TOKEN
        return NO_TOKEN


def _is_same(shown: str, secret: bytes) -> bool:
    """Compare in constant time. Bytes that are not valid text arrive as lone surrogates."""
    return hmac.compare_digest(shown.encode(errors="surrogatepass"), secret)


class WrongTokenDelay:
    """Delays of answers to wrong tokens, by client address.

    Args:
        now: a clock, in seconds.
    """

    def __init__(self, now: Callable[[], float]) -> None:
        self._now = now
        self._wrong: OrderedDict[str, deque[float]] = OrderedDict()

    def next_delay(self, remote: str) -> float:
        """Record a wrong token; return the seconds to wait before it is answered."""
        now = self._now()
        times = self._wrong.setdefault(remote, deque(maxlen=100))
        self._wrong.move_to_end(remote)
        while len(self._wrong) > _MAX_ADDRESSES:
            self._wrong.popitem(last=False)
        while times and now - times[0] > _WINDOW_S:
            times.popleft()
        times.append(now)
        return min(_MAX_DELAY_S, max(0.0, float(len(times) - _FREE_ATTEMPTS)))

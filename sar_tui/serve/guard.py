"""Access control: the token or its cookie, the host name, and the origin of a request."""

import hmac
import os
import secrets
import stat
from collections import OrderedDict, deque
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from sar_tui.drivers.files import write_private
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


# --- the token


_MIN_LENGTH = 22
"""Characters; 128 bits."""


class TokenError(ValueError):
    """A token cannot be stored or read; the message is one or two clear sentences."""


def new_token() -> str:
    """Return a new random token."""
    return secrets.token_urlsafe(32)


def load_or_create_token(path: Path) -> str:
    """Return the token in a file, which is created if it does not exist.

    Raises:
        TokenError: others can read the file, it contains no token, or it cannot be used.
    """
    try:
        with open(path, encoding="ascii") as file:
            _refuse_shared(path, os.fstat(file.fileno()))
            token = file.read(1000).strip()
    except FileNotFoundError:
        return _create(path)
    except OSError as error:
        raise TokenError(f"The token file {path} cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError:
        token = ""
    if len(token) < _MIN_LENGTH or not all(
        character.isalnum() or character in "-_" for character in token
    ):
        raise TokenError(
            f"The file {path} contains no token: {_MIN_LENGTH} or more letters, digits, - and _. "
            "Give the name of a new file to create one."
        )
    return token


def _refuse_shared(path: Path, status: os.stat_result) -> None:
    if os.name == "posix" and stat.S_IMODE(status.st_mode) & 0o077:
        raise TokenError(
            f"Other users can read the token file {path}: run chmod 600 {path}, or use another "
            "file."
        )


def _create(path: Path) -> str:
    token = new_token()
    try:
        write_private(path, f"{token}\n")
    except OSError as error:
        raise TokenError(f"The token file {path} cannot be created: {error.strerror}.") from error
    return token

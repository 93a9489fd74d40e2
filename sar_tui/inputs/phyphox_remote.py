"""The app phyphox by its remote access: requests over HTTP, and what comes back."""

import http.client
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, NamedTuple, TypeVar
from urllib.parse import quote

import msgspec

from sar_tui.model.visible_text import visible

REPLY_S = 2.0
"""Longest wait for a reply."""
TRANSPORT_ERRORS = (OSError, http.client.HTTPException, msgspec.DecodeError)
"""Raised by a request that is not answered, or not by the app."""

_MOST_BYTES = 16_000_000
_LARGEST_RANGE = 10_000.0

Query = list[tuple[str, str]]
"""Names of buffers, and what is asked for of each."""
_T = TypeVar("_T")


class Buffer(msgspec.Struct, frozen=True):
    mode: str = msgspec.field(name="updateMode")
    values: list[float | None] = msgspec.field(name="buffer")


class State(msgspec.Struct, frozen=True):
    """State of the phone. ``session`` changes with each experiment that is opened."""

    session: str = ""
    measuring: bool = False
    timed: bool = msgspec.field(name="timedRun", default=False)


class Reply(msgspec.Struct, frozen=True):
    buffers: dict[str, Buffer] = msgspec.field(name="buffer")
    state: State = msgspec.field(name="status")


class Input(msgspec.Struct, frozen=True):
    source: str
    outputs: list[dict[str, str]] = []


class Config(msgspec.Struct, frozen=True):
    title: str = ""
    inputs: list[Input] = []


class _Control(msgspec.Struct, frozen=True):
    result: bool = False


class Asked(NamedTuple):
    """A reply, and when its request was sent and its last byte had come (ns, host)."""

    reply: Reply
    sent_ns: int
    came_ns: int


class Device(NamedTuple):
    """Description of a phone; a range is 0 if unknown."""

    model: str = "phyphox"
    rate_range: float = 0.0
    acceleration_range: float = 0.0


class Connection:
    """Requests to the app, one after the other. A lost connection is made again with the next."""

    def __init__(self, host: str, port: int, now: Callable[[], int]) -> None:
        self._http = http.client.HTTPConnection(host, port, timeout=REPLY_S)
        self._now = now
        self._is_used = False

    def close(self) -> None:
        """Close the connection."""
        self._http.close()
        self._is_used = False

    def get(self, query: Query) -> Asked:
        """Ask for buffers. Raises one of the transport's errors."""
        sent_ns = self._now()
        asked = "&".join(f"{quote(name)}={quote(value)}" for name, value in query)
        reply = self.ask(f"/get?{asked}", Reply)
        return Asked(reply, sent_ns, self._came_ns)

    def control(self, command: str) -> bool:
        """Send a command; return True if it was carried out. Raises one of the transport's
        errors.
        """
        return self.ask(f"/control?cmd={command}", _Control).result

    def device(self) -> Device:
        """Return what the phone says of itself: not much, from some."""
        try:
            meta = self.ask("/meta", dict[str, Any])
        except msgspec.DecodeError:
            return Device()
        model = visible(str(meta.get("deviceModel") or ""))[:40]
        return Device(
            f"{model} (phyphox)" if model else "phyphox",
            _range(meta, "gyroscope"),
            _range(meta, "accelerometer"),
        )

    def ask(self, path: str, kind: type[_T]) -> _T:
        """Return the reply to a request. Raises one of the transport's errors."""
        try:
            body = self._body(path)
        except (http.client.RemoteDisconnected, BrokenPipeError, ConnectionResetError):
            if not self._is_used:
                raise
            self.close()  # the server closed it after an earlier reply
            body = self._body(path)
        self._is_used = True
        return msgspec.json.decode(body, type=kind)

    def _body(self, path: str) -> bytes:
        self._http.request("GET", path)
        body = self._http.getresponse().read(_MOST_BYTES)
        self._came_ns = self._now()
        return body


def _range(meta: Mapping[str, Any], sensor: str) -> float:
    """Return the largest value of a sensor, which some phones do not tell."""
    with suppress(AttributeError, TypeError, ValueError):
        value = float(meta["sensors"][sensor]["Range"])
        return value if 0 < value < _LARGEST_RANGE else 0.0
    return 0.0

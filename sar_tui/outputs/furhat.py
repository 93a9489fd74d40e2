"""A Furhat robot, or its virtual one, by its realtime API: events in JSON over a WebSocket.

The events are those of the package furhat-realtime-api, which is not needed.
"""

import json
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from sar_tui.drivers.address import Address
from sar_tui.drivers.installation import pip_install_extra
from sar_tui.model.messages import PartState
from sar_tui.model.units import SECOND
from sar_tui.outputs.output import OutputError
from sar_tui.outputs.robot import (
    Answer,
    Changed,
    Heard,
    Link,
    OwnNames,
    Request,
    Robot,
    read_address,
)

PORT = 9000
CONNECT_S = 3.0
"""Time limit of a connection, and of the answer to the key."""
PING_S = 3.0
"""Interval of pings, and the time limit for each reply."""
RETRY_S = 1.0
"""Pause before a connection is tried again."""
CLOSE_S = 1.0
"""Longest wait for the robot when closing."""
FIRST_WORD = 6 * SECOND
"""Time in which it must begin to speak: a text that it has not spoken before is synthesised by a
service, which takes a second or more.
"""
_AWAY = {
    "ahead": (0.0, 0.0),
    "left": (-0.5, 0.0),
    "right": (0.5, 0.0),
    "up": (0.0, 0.4),
    "down": (0.0, -0.4),
}
"""Point to look at, 1 m away: to the participant's right, which is the robot's left, and up (m)."""
_UNSTOPPABLE = "Furhat does not stop a gesture: it ends by itself, within a second or two."
_EXAMPLE = (
    "furhat://HOST or furhat://HOST:PORT; after a question mark, joined by &, there may be "
    "key_file=, a file that holds the key of the robot's realtime API, and its gesture for one of "
    "the theme, such as wave=Wink"
)


class Options(OwnNames, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Options after the question mark of an address."""

    key_file: str = ""
    nod: str = "Nod"
    shake: str = "Shake"
    cheer: str = "BigSmile"
    lean_in: str = "BrowRaise"


class Events:
    """The connection: requests with an id, which the robot's events about them repeat."""

    def __init__(self, address: Address, options: Options, changed: Changed, heard: Heard) -> None:
        self._address, self._options = address, options
        self._changed, self._heard = changed, heard
        self.problem = ""
        self._socket: Any = None
        self._closed = threading.Event()
        self._open: dict[str, Request] = {}
        self._number = 0

    @property
    def is_connected(self) -> bool:
        return self._socket is not None

    def open(self) -> None:
        threading.Thread(target=self._run, name="furhat", daemon=True).start()

    def send(self, request: Request) -> bool:
        match request.part:
            case "say":
                event = {"type": "request.speak.text", "text": request.what, "abort": False}
                request.answer = FIRST_WORD
            case "gesture":
                name = self._options.of(request.what)
                event = {"type": "request.gesture.start", "name": name, "monitor": True}
            case _:
                right, up = _AWAY.get(request.what, (0.0, 0.0))
                event = {"type": "request.attend.location", "x": right, "y": up, "z": 1.0}
                if request.what == "ahead":
                    event = {"type": "request.attend.user", "user_id": "closest"}
        self._number += 1
        id = f"{request.id}-{self._number}"
        self._open[id] = request
        is_sent = self._send(event | {"request_id": id})
        if not is_sent:
            del self._open[id]
        elif request.part == "gaze":  # there is no answer
            self._over(id, "done")
        return is_sent

    def stop(self, id: str) -> bool:
        stopped = {
            key: request for key, request in list(self._open.items()) if id in ("", request.id)
        }
        is_sent = self.is_connected
        if not id or any(request.part == "say" for request in stopped.values()):
            is_sent = self._send({"type": "request.speak.stop"})
        for key, request in stopped.items():
            if request.part == "gesture":
                self._over(key, "aborted", _UNSTOPPABLE)
        return is_sent

    def close(self) -> None:
        self._closed.set()
        socket, self._socket = self._socket, None
        if socket is not None:
            with suppress(Exception):
                socket.close()

    def _send(self, event: dict[str, Any]) -> bool:
        socket = self._socket
        if socket is None:
            return False
        try:
            socket.send(json.dumps(event))
        except Exception:  # the loss is reported by the thread that receives
            return False
        return True

    def _over(self, id: str, state: PartState, detail: str = "") -> None:
        if request := self._open.pop(id, None):
            self._heard(Answer(state, request.id, request.part, detail))

    # --- on the connection's thread

    def _run(self) -> None:
        """Connect, and again whenever the connection is lost, until closed or refused."""
        try:
            from websockets.exceptions import WebSocketException
            from websockets.sync.client import connect
        except ImportError:
            self._refuse(
                "The Python package websockets is missing; install it with: "
                + pip_install_extra("furhat")
            )
            return
        try:
            key = read_key(self._options.key_file)
        except OutputError as error:
            self._refuse(str(error))
            return
        while not self._closed.is_set() and not self.problem:
            with (
                suppress(OSError, WebSocketException, ValueError),
                connect(
                    f"ws://{self._address.netloc}/v1/events",
                    open_timeout=CONNECT_S,
                    close_timeout=CLOSE_S,
                    ping_interval=PING_S,
                    ping_timeout=PING_S,
                    compression=None,
                    proxy=None,
                ) as socket,
            ):
                if self._authenticate(socket, key):
                    self._receive(socket)
            self._lose()
            self._closed.wait(RETRY_S)

    def _authenticate(self, socket: Any, key: str) -> bool:
        """Give the key; also without one, as the robot wants it."""
        asked = {"type": "request.auth", "request_id": "auth"} | ({"key": key} if key else {})
        socket.send(json.dumps(asked))
        until = time.monotonic() + CONNECT_S
        while (event := _read(socket.recv(timeout=until - time.monotonic()))).get(
            "type"
        ) != "response.auth":
            pass
        if event.get("access") is True:
            return True
        self._refuse(
            f"The Furhat at {self._address} does not accept the key in {self._options.key_file}."
            if key
            else f"The Furhat at {self._address} wants a key: write it into a file, and add "
            "?key_file=FILE to the address."
        )
        return False

    def _receive(self, socket: Any) -> None:
        if self._closed.is_set():
            return
        self._socket = socket
        self._changed()
        for message in socket:
            if not self._closed.is_set():
                self._hear(_read(message))

    def _hear(self, event: dict[str, Any]) -> None:
        of, _, what = str(event.get("type", "")).removeprefix("response.").rpartition(".")
        part = {"speak": "say", "gesture": "gesture"}.get(of)
        id = event.get("request_id") or self._oldest(part)
        if event.get("error") or what == "error":
            self._over(id, "failed", str(event.get("error") or event.get("message") or ""))
        elif part and what == "start" and (request := self._open.get(id)):
            self._heard(Answer("started", request.id, request.part))
        elif part and what == "end":
            self._over(id, "aborted" if event.get("aborted") else "done")

    def _oldest(self, part: str | None) -> str:
        """Return the request that an event without an id is about."""
        open = list(self._open.items())
        return next((id for id, request in open if request.part == part), "")

    def _lose(self) -> None:
        was_connected, self._socket = self._socket is not None, None
        self._open.clear()
        if was_connected and not self._closed.is_set():
            self._changed()

    def _refuse(self, problem: str) -> None:
        self.problem = problem
        if not self._closed.is_set():
            self._changed()


def _read(message: str | bytes) -> dict[str, Any]:
    """Return an event; empty if it is not one."""
    try:
        event = json.loads(message)
    except ValueError:
        return {}
    return event if isinstance(event, dict) else {}


def read_key(path: str) -> str:
    """Return the key in a file; none without a file.

    Raises:
        OutputError: it cannot be read.
    """
    try:
        return Path(path).expanduser().read_text(encoding="utf-8").strip() if path else ""
    except (OSError, UnicodeError) as error:
        raise OutputError(f"The key of the Furhat cannot be read from {path}: {error}.") from error


class Furhat(Robot):
    """A Furhat robot. It speaks with the voice that is chosen on the robot.

    Args:
        address: ``furhat://HOST[:PORT]``, and after a question mark `Options`. Raises OutputError
            if it is invalid.
    """

    name = "furhat"

    def __init__(self, address: str) -> None:
        self._address, self._options = read_address(address, "furhat", PORT, Options, _EXAMPLE)
        self.place = str(self._address)
        self.missing = (
            f"no Furhat answers at {self.place}. Start it, and switch its realtime API on."
        )

    def connect(self, changed: Changed, heard: Heard) -> Link:
        return Events(self._address, self._options, changed, heard)

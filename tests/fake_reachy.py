"""A fake Reachy Mini: the part of its daemon's HTTP interface that sar-tui uses.

It answers as the daemon of reachy-mini 1.13.0 does (Apache-2.0, github.com/pollen-robotics/
reachy_mini, src/reachy_mini/daemon/app/routers/move.py and media.py), with which it was compared:
two movements may be under way at the same time; to stop one that has ended is an internal error; a
sound is played without an answer when it ends.
"""

import json
import re
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, Literal
from uuid import uuid4

Manner = Literal["obliging", "failing", "muddled", "deaf", "unplayable"]
_POSE = {"x", "y", "z", "roll", "pitch", "yaw"}


class FakeReachy:
    """A Reachy Mini. Its port stays the same when it stops listening and starts again.

    Args:
        manner: how it reacts. ``obliging``: does what it is asked. ``failing``: refuses movements
            and sounds, as its backend is not running. ``muddled``: answers what is no JSON.
            ``deaf``: takes a second to stop. ``unplayable``: refuses sounds that are uploaded.
        pace: how much shorter its movements are than asked for.

    Attributes:
        asked: each request: its method and path, and its JSON.
        sounds: sounds that were uploaded and not deleted, by their names.
        status: fields of the daemon's status that differ.
    """

    def __init__(self, manner: Manner = "obliging", pace: float = 1.0) -> None:
        self.manner: Manner = manner
        self.pace = pace
        self.port = 0
        self.asked: list[tuple[str, Any]] = []
        self.sounds: dict[str, bytes] = {}
        self.playing = ""
        self.status: dict[str, Any] = {}
        self._moves: dict[str, float] = {}
        self._server: ThreadingHTTPServer | None = None
        self._thawed = threading.Event()
        self._thawed.set()

    @property
    def host(self) -> str:
        return f"127.0.0.1:{self.port}"

    def arrive(self) -> None:
        """Start to listen."""
        robot = self

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                robot.respond(self)

            do_POST = do_DELETE = do_GET  # noqa: N815

            def log_message(self, *_: object) -> None:
                pass

        self._server = ThreadingHTTPServer(("127.0.0.1", self.port), Handler)
        self.port = self._server.server_address[1]
        threading.Thread(
            target=self._server.serve_forever, args=(0.01,), name="reachy server", daemon=True
        ).start()

    def leave(self) -> None:
        """Refuse connections."""
        if self._server:
            self._server.shutdown()
            self._server.server_close()
            self._server = None

    def freeze(self) -> None:
        """Accept requests, and do not answer."""
        self._thawed.clear()

    def thaw(self) -> None:
        """Continue after hanging."""
        self._thawed.set()

    def close(self) -> None:
        """Stop for good."""
        self.thaw()
        self.leave()

    def paths(self) -> list[str]:
        """Return the requests but for those that only look."""
        return [path for path, _ in list(self.asked) if not path.startswith("GET")]

    def gotos(self) -> list[Any]:
        """Return the movements that were asked for."""
        return [what for path, what in list(self.asked) if path == "POST /api/move/goto"]

    def running(self) -> list[str]:
        """Return the movements under way."""
        now = time.monotonic()
        self._moves = {uuid: end for uuid, end in self._moves.items() if end > now}
        return list(self._moves)

    def respond(self, request: BaseHTTPRequestHandler) -> None:
        """Answer a request."""
        body = request.rfile.read(int(request.headers.get("Content-Length") or 0))
        kind = request.headers.get("Content-Type", "")
        path = f"{request.command} {request.path}"
        what = json.loads(body) if kind == "application/json" else None
        self.asked.append((path, what))
        self._thawed.wait(30)
        if self.manner == "muddled" and "status" not in path:
            status, answer = 200, b"tea"
        else:
            status, said = self._answer(path, what, body)
            answer = json.dumps(said).encode()
        request.send_response(status)
        request.send_header("Content-Length", str(len(answer)))
        request.end_headers()
        request.wfile.write(answer)

    def _answer(self, path: str, what: Any, body: bytes) -> tuple[int, Any]:
        status: int = 200
        answer: Any = {"status": "ok"}
        match path.split("/api/", 1):
            case ["GET ", "daemon/status"]:
                backend = {"motor_control_mode": "enabled"}
                answer = {"state": "running", "no_media": False, "backend_status": backend}
                answer |= self.status
            case _ if self.manner == "failing":
                status, answer = 503, {"detail": "Backend not running"}
            case ["GET ", "move/running"]:
                answer = [{"uuid": uuid} for uuid in self.running()]
            case ["POST ", "move/goto"]:
                status, answer = self._goto(what)
            case ["POST ", "move/stop"] if what["uuid"] not in self.running():
                status, answer = 500, "Internal Server Error"
            case ["POST ", "move/stop" | "media/stop_sound" as stopped]:
                if self.manner == "deaf":
                    time.sleep(1)
                if stopped == "move/stop":
                    self._moves.pop(what["uuid"], None)
                else:
                    self.playing = ""
            case ["POST ", "media/sounds/upload"]:
                status, answer = self._upload(body)
            case ["POST ", "media/play_sound"]:
                self.playing = what["file"]
            case [_, name]:
                self.sounds.pop(name.rpartition("/")[2], None)
        return status, answer

    def _goto(self, what: Any) -> tuple[int, Any]:
        if set(what["head_pose"]) - _POSE or len(what["antennas"]) != 2:
            return 422, {"detail": "Unprocessable"}
        uuid = str(uuid4())
        self._moves[uuid] = time.monotonic() + what["duration"] * self.pace
        return 200, {"uuid": uuid}

    def _upload(self, body: bytes) -> tuple[int, Any]:
        found = re.search(rb'name="file"; filename="([^"]+)".*?\r\n\r\n(.*)\r\n--', body, re.DOTALL)
        if not found or not found[1].endswith(b".wav"):
            return 400, {"detail": "Filename is required"}
        if self.manner == "unplayable" or not found[2].startswith(b"RIFF"):
            return 400, {"detail": "Unsupported or invalid audio file"}
        self.sounds[found[1].decode()] = found[2]
        return 200, {"status": "ok", "path": f"/tmp/reachy_mini_sounds/{found[1].decode()}"}


@contextmanager
def reachy(manner: Manner = "obliging", pace: float = 1.0) -> Iterator[FakeReachy]:
    """Run a server until the end of the block."""
    server = FakeReachy(manner, pace)
    server.arrive()
    try:
        yield server
    finally:
        server.close()

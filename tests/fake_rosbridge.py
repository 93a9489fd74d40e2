"""A fake ROS system: a rosbridge server on this computer, with a robot and a motion sensor.

It implements the part of the rosbridge v2 protocol that sar-tui uses, as RobotWebTools documents it
(github.com/RobotWebTools/rosbridge_suite, ROSBRIDGE_PROTOCOL.md): advertise, unadvertise, publish,
subscribe, unsubscribe, set_level and status, each a JSON object with an ``op``, in a WebSocket's
text frame.
"""

import asyncio
import importlib
import json
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, Literal

import pytest
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

DEADLINE_S = 60.0
"""Time to wait for another thread before a test fails."""
REPORT = "/sar_tui/report"
PARTS = {"speech": "say", "gesture": "gesture", "gaze": "gaze"}
KNOWN_TYPES = ("std_msgs/String", "sensor_msgs/Imu")
Manner = Literal["obliging", "silent", "slow", "failing", "muddled", "breaking off", "terse"]


def hide_roslibpy(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the package impossible to import.

    It is imported before: an import under way in the thread of an earlier test would remain half
    done.
    """
    importlib.import_module("roslibpy.comm.comm_asyncio")
    for name in ("roslibpy", "roslibpy.comm"):
        monkeypatch.setitem(sys.modules, name, None)


def wait_until(happened: Callable[[], Any], what: str = "it") -> None:
    """Wait for another thread."""
    deadline = time.monotonic() + DEADLINE_S
    while not happened():
        assert time.monotonic() < deadline, f"timed out waiting until {what}"
        time.sleep(0.002)


class RosBridge:
    """A rosbridge server with a robot. Its port stays the same when it stops listening and starts
    again.

    Args:
        manner: how the robot reacts to a request. ``obliging``: starts and completes it.
            ``silent``: reports nothing. ``slow``: starts it and never ends. ``failing``: reports a
            failure. ``muddled``: reports nonsense. ``breaking off``: starts it, then aborts.
            ``terse``: as ``obliging``, but without the id and the part in its reports. All but
            ``silent`` report what a stop aborted.
        lasts_s: time that an obliging robot takes for a part.

    Attributes:
        received: every message of a client, in order.
        connections: number of connections so far.
    """

    def __init__(self, manner: Manner = "obliging", lasts_s: float = 0.0) -> None:
        self.manner: Manner = manner
        self.lasts_s = lasts_s
        self.port = 0
        self.received: list[dict[str, Any]] = []
        self.connections = 0
        self._clients: dict[ServerConnection, tuple[dict[str, str], set[str]]] = {}
        self._under_way: list[dict[str, str]] = []
        self._endings: set[asyncio.Task[None]] = set()
        self._loop = asyncio.new_event_loop()
        self._server: Any = None
        self._thread = threading.Thread(
            target=self._loop.run_forever, name="rosbridge server", daemon=True
        )
        self._thread.start()
        self._thawed = threading.Event()
        self._thawed.set()

    @property
    def host(self) -> str:
        return f"127.0.0.1:{self.port}"

    def arrive(self) -> None:
        """Start to listen for connections."""
        self._do(self._listen())

    def leave(self) -> None:
        """Cut every connection, and refuse new ones."""
        self._do(self._shut())

    def freeze(self) -> None:
        """Hang as if the cable was pulled: connections stay open without data."""
        self._thawed.clear()
        self._loop.call_soon_threadsafe(self._thawed.wait)

    def thaw(self) -> None:
        """Continue after hanging."""
        self._thawed.set()

    def close(self) -> None:
        """Stop for good."""
        self.thaw()
        self.leave()
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(DEADLINE_S)
        self._loop.close()

    def publish(self, topic: str, message: Any) -> None:
        """Send a message to all subscribers."""
        self._do(self._publish(topic, message))

    def send(self, text: str) -> None:
        """Send raw data to all connections."""
        self._do(self._send(text))

    def data(self, topic: str) -> list[str]:
        """Return the messages received on a topic of ``std_msgs/String``."""
        return [
            said["msg"]["data"]
            for said in list(self.received)
            if said["op"] == "publish" and said["topic"] == topic
        ]

    def ops(self, op: str) -> list[str]:
        """Return the topics of the requests for an operation."""
        return [said["topic"] for said in list(self.received) if said["op"] == op]

    def has_clients(self) -> bool:
        """True if there is a connection."""
        return bool(self._clients)

    def has_subscriber(self, topic: str) -> bool:
        """Return True if a topic has a subscriber."""
        return any(topic in subscribed for _, subscribed in list(self._clients.values()))

    def _do(self, work: Any) -> None:
        asyncio.run_coroutine_threadsafe(work, self._loop).result(DEADLINE_S)

    async def _listen(self) -> None:
        self._server = await serve(self._attend, "127.0.0.1", self.port)
        self.port = self._server.sockets[0].getsockname()[1]

    async def _shut(self) -> None:
        for ending in self._endings:
            ending.cancel()
        if self._server is not None:
            for client in list(self._clients):
                client.transport.abort()
            self._server.close()
            await self._server.wait_closed()
            self._server = None

    async def _attend(self, client: ServerConnection) -> None:
        self.connections += 1
        self._clients[client] = ({}, set())
        with suppress(ConnectionClosed):
            async for frame in client:
                said = json.loads(frame)
                self.received.append(said)
                await self._answer(client, said)
        del self._clients[client]

    async def _answer(self, client: ServerConnection, said: dict[str, Any]) -> None:
        advertised, subscribed = self._clients[client]
        match said:
            case {"op": "advertise", "topic": topic, "type": kind} if kind in KNOWN_TYPES:
                advertised[topic] = kind
            case {"op": "unadvertise", "topic": topic}:
                advertised.pop(topic, None)
            case {"op": "subscribe", "topic": topic}:
                subscribed.add(topic)
            case {"op": "unsubscribe", "topic": topic}:
                subscribed.discard(topic)
            case {"op": "set_level"}:
                pass
            case {"op": "publish", "topic": topic, "msg": {"data": str(data)}} if (
                topic in advertised
            ):
                await self._robot(topic.rpartition("/")[2], data)
            case _:
                words = f"{said.get('op')}: refused"
                await client.send(json.dumps({"op": "status", "level": "error", "msg": words}))

    async def _robot(self, what: str, data: str) -> None:
        """Act as a robot with a speech, a gesture, a gaze and a stop topic, and report."""
        under_way = []
        if what == "stop":
            under_way, self._under_way = self._under_way, []
            for ending in self._endings:
                ending.cancel()
        if self.manner == "silent":
            return
        try:
            asked = json.loads(data)
        except ValueError:
            asked = {}
        names = (
            {"id": asked.get("id", ""), "deed": PARTS.get(what, "")}
            if self.manner != "terse"
            else {}
        )
        if what == "stop":
            for stopped in under_way:
                await self._report(stopped, "aborted")
        elif self.manner == "muddled":
            await self._publish(REPORT, {"data": "I am a teapot"})
            await self._report(names, "dreaming")
        elif self.manner == "failing":
            await self._report(names, "failed", "My arm is\x1b[2J stuck.")
        else:
            await self._report(names, "started")
            if self.manner == "breaking off":
                await self._report(names, "aborted", "Somebody came too near.")
                return
            self._under_way.append(names)
            if self.manner in ("obliging", "terse"):
                ending = self._loop.create_task(self._finish(names))
                self._endings.add(ending)
                ending.add_done_callback(self._endings.discard)

    async def _finish(self, names: dict[str, str]) -> None:
        await asyncio.sleep(self.lasts_s)
        self._under_way.remove(names)
        await self._report(names, "done")

    async def _report(self, names: dict[str, str], state: str, detail: str = "") -> None:
        await self._publish(
            REPORT, {"data": json.dumps(names | {"state": state, "detail": detail})}
        )

    async def _publish(self, topic: str, message: Any) -> None:
        for client, (_, subscribed) in list(self._clients.items()):
            if topic in subscribed:
                with suppress(ConnectionClosed):  # The client may be disconnecting.
                    await client.send(json.dumps({"op": "publish", "topic": topic, "msg": message}))

    async def _send(self, text: str) -> None:
        for client in list(self._clients):
            await client.send(text)


@contextmanager
def ros_bridge(manner: Manner = "obliging", lasts_s: float = 0.0) -> Iterator[RosBridge]:
    """Run a server until the end of the block."""
    bridge = RosBridge(manner, lasts_s)
    bridge.arrive()
    try:
        yield bridge
    finally:
        bridge.close()

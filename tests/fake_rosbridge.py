"""A fake ROS system: a rosbridge server on this computer, with a robot and a motion sensor.

It implements the part of the rosbridge v2 protocol that sar-tui uses, as RobotWebTools documents it
(github.com/RobotWebTools/rosbridge_suite, ROSBRIDGE_PROTOCOL.md): advertise, unadvertise, publish,
subscribe, unsubscribe, set_level, status, call_service, send_action_goal and cancel_action_goal, each
a JSON object with an ``op``, in a WebSocket's text frame. Actions are answered as
rosbridge_library/capabilities/send_action_goal.py does: a goal is known by its id to every
connection, and to cancel one that is not accepted yet has no effect. The results are those of
ROS4HRI skills (github.com/ros4hri: std_skills/Result).
"""

import asyncio
import importlib
import json
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any, Literal

import pytest
from websockets.asyncio.server import ServerConnection

from tests.fake_server import DEADLINE_S, FakeServer

REPORT = "/sar_tui/report"
PARTS = {"speech": "say", "gesture": "gesture", "gaze": "gaze"}
SKILLS = ("/skill/say", "/skill/replay_motion", "/skill/look_at")
MOTIONS = ("wave", "nod", "bow")
ACCEPTED_S = 0.005
"""Time until a robot has accepted a goal; it cannot be cancelled before."""
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


class RosBridge(FakeServer):
    """A rosbridge server with a robot.

    Args:
        manner: how the robot reacts to a request. ``obliging``: starts and completes it.
            ``silent``: reports nothing. ``slow``: starts it and never ends. ``failing``: reports a
            failure. ``muddled``: reports nonsense. ``breaking off``: starts it, then aborts.
            ``terse``: as ``obliging``, but without the id and the part in its reports. All but
            ``silent`` report what a stop aborted.
        lasts_s: time that an obliging robot takes for a part.
        skills: the actions that the robot has.
        one_at_a_time: take up the messages of a connection only when its goal has ended, as
            rosbridge does by default up to 2.1.0.
    """

    def __init__(
        self,
        manner: Manner = "obliging",
        lasts_s: float = 0.0,
        skills: Sequence[str] = SKILLS,
        one_at_a_time: bool = False,
    ) -> None:
        super().__init__()
        self.manner: Manner = manner
        self.lasts_s = lasts_s
        self.skills = skills
        self.one_at_a_time = one_at_a_time
        self._topics: dict[ServerConnection, tuple[dict[str, str], set[str]]] = {}
        self._under_way: list[dict[str, str]] = []
        self._endings: set[asyncio.Task[None]] = set()
        self._goals: dict[str, asyncio.Event] = {}

    def publish(self, topic: str, message: Any) -> None:
        """Send a message to all subscribers."""
        self._do(self._publish(topic, message))

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

    def has_subscriber(self, topic: str) -> bool:
        """Return True if a topic has a subscriber."""
        return any(topic in subscribed for _, subscribed in list(self._topics.values()))

    def goals(self, skill: str) -> list[dict[str, Any]]:
        """Return the goals that a skill has received."""
        name = f"/skill/{skill}"
        return [
            said["args"]
            for said in list(self.received)
            if said["op"] == "send_action_goal" and said["action"] == name
        ]

    def left(self, client: ServerConnection) -> None:
        self._topics.pop(client, None)

    async def answer(self, client: ServerConnection, said: dict[str, Any]) -> None:
        advertised, subscribed = self._topics.setdefault(client, ({}, set()))
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
            case {"op": "call_service" | "send_action_goal" | "cancel_action_goal"}:
                await self._skill(client, said)
            case _:
                words = f"{said.get('op')}: refused"
                await client.send(json.dumps({"op": "status", "level": "error", "msg": words}))

    async def _skill(self, client: ServerConnection, said: dict[str, Any]) -> None:
        match said:
            case {"op": "call_service", "service": "/rosapi/action_servers", "id": id}:
                answer = {"op": "service_response", "id": id, "result": True}
                answer |= {"service": said["service"], "values": {"action_servers": self.skills}}
                await self.tell(client, answer)
            case {"op": "send_action_goal", "id": id, "action": name, "args": dict(args)}:
                if name in self.skills:  # rosbridge waits for ever for one that is not there
                    goal = self.do_later(self._pursue(client, id, name, args))
                    if self.one_at_a_time:
                        await asyncio.wait({goal})
            case {"op": "cancel_action_goal", "id": id}:
                if (cancelled := self._goals.get(id)) and self.manner != "silent":
                    cancelled.set()

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
                ending = self.do_later(self._finish(names))
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
        for client, (_, subscribed) in list(self._topics.items()):
            if topic in subscribed:
                await self.tell(client, {"op": "publish", "topic": topic, "msg": message})

    async def _pursue(
        self, client: ServerConnection, id: str, name: str, args: dict[str, Any]
    ) -> None:
        """Act as the server of a skill: accept the goal, give feedback, and a result."""
        await asyncio.sleep(ACCEPTED_S)
        cancelled = self._goals[id] = asyncio.Event()
        about = {"action": name, "id": id}
        if self.manner not in ("silent", "terse", "failing", "muddled"):
            values = {"feedback": {"data_str": ""}}
            await self.tell(client, {"op": "action_feedback", "values": values} | about)
        status, code, words, more = 4, 0, "", {}
        if name == "/skill/replay_motion" and args["name"] not in MOTIONS:
            status, code, more = 6, 22, {"available_motions": list(MOTIONS)}
        elif self.manner == "failing":
            status, code, words = 6, 5, "My arm is\x1b[2J stuck."
        elif self.manner == "breaking off":
            status, code, words = 6, 4, "Somebody came too near."
        else:
            waits = self.lasts_s if self.manner in ("obliging", "terse", "muddled") else None
            with suppress(TimeoutError):
                await asyncio.wait_for(cancelled.wait(), waits)
                status, code = 5, 125
        self._goals.pop(id, None)
        result = {"result": {"error_code": code, "error_msg": words}} | more
        if self.manner == "muddled":
            result = {"result": "tea"}
        answer = {"op": "action_result", "values": result, "status": status, "result": True}
        await self.tell(client, answer | about)


@contextmanager
def ros_bridge(manner: Manner = "obliging", lasts_s: float = 0.0) -> Iterator[RosBridge]:
    """Run a server until the end of the block."""
    bridge = RosBridge(manner, lasts_s)
    bridge.arrive()
    try:
        yield bridge
    finally:
        bridge.close()

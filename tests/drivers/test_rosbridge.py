"""Connections to a rosbridge server that comes and goes."""

import logging
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from sar_tui.drivers import rosbridge
from sar_tui.drivers.address import Address, AddressError, parse
from sar_tui.drivers.rosbridge import Bridge
from tests.fake_rosbridge import RosBridge, ros_bridge, wait_until

STRING = "std_msgs/String"


class Caller:
    """A program that publishes to one topic and subscribes to another."""

    def __init__(self, port: int) -> None:
        self.received: list[Any] = []
        self.changes: list[bool] = []
        self.bridge = Bridge(
            Address("127.0.0.1", port, "", {}),
            {"/out": STRING},
            {"/in": (STRING, self.received.append)},
            lambda: self.changes.append(self.bridge.is_connected),
        )
        self.bridge.open()

    def say(self, text: str) -> bool:
        return self.bridge.publish("/out", {"data": text})

    def wait_until_connected(self, server: RosBridge) -> None:
        wait_until(
            lambda: self.bridge.is_connected and server.has_subscriber("/in"), "it is connected"
        )

    def wait_until_away(self) -> None:
        wait_until(lambda: not self.bridge.is_connected, "the loss is noticed")


@pytest.fixture
def call(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[int], Caller]]:
    """Open connections that soon try again, and close them at the end."""
    monkeypatch.setattr(rosbridge, "FIRST_RETRY_S", 0.02)
    monkeypatch.setattr(rosbridge, "LONGEST_RETRY_S", 0.05)
    callers: list[Caller] = []

    def call(port: int) -> Caller:
        callers.append(Caller(port))
        return callers[-1]

    yield call
    for caller in callers:
        caller.bridge.close()


@pytest.fixture
def server() -> Iterator[RosBridge]:
    with ros_bridge("silent") as server:
        yield server


def free_port() -> int:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return int(taken.getsockname()[1])


def test_it_advertises_and_subscribes_before_it_publishes_and_again_when_the_server_was_away(
    server: RosBridge, call: Callable[[int], Caller]
) -> None:
    caller = call(server.port)
    caller.wait_until_connected(server)
    assert caller.say("hello")
    wait_until(lambda: server.data("/out") == ["hello"])
    assert [(said["op"], said["topic"]) for said in server.received] == [
        ("advertise", "/out"),
        ("subscribe", "/in"),
        ("publish", "/out"),
    ]
    server.leave()
    caller.wait_until_away()
    assert [caller.say(f"lost {n}") for n in range(100)] == [False] * 100
    server.arrive()
    caller.wait_until_connected(server)
    assert caller.say("back")
    wait_until(lambda: len(server.data("/out")) == 2)
    assert server.data("/out") == ["hello", "back"], "nothing was queued"
    assert server.ops("advertise") == ["/out", "/out"]
    assert server.ops("subscribe") == ["/in", "/in"]
    server.publish("/in", {"data": "once"})
    server.publish("/in", {"data": "twice"})
    wait_until(lambda: len(caller.received) >= 2)
    assert caller.received == [{"data": "once"}, {"data": "twice"}]
    assert caller.changes == [True, False, True]


def test_a_server_that_hangs_is_given_up_and_taken_up_again(
    server: RosBridge, call: Callable[[int], Caller], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rosbridge, "PING_S", 0.1)
    caller = call(server.port)
    caller.wait_until_connected(server)
    server.freeze()
    caller.wait_until_away()
    server.thaw()
    caller.wait_until_connected(server)


def test_closing_ends_the_attempts_to_find_a_server(
    call: Callable[[int], Caller], caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.DEBUG, "roslibpy"):
        caller = call(free_port())
        wait_until(lambda: "Will retry" in caplog.text)
        caller.bridge.close()
        wait_until(lambda: "giving up" in caplog.text)
    assert caller.changes == []


def test_a_connection_made_after_closing_is_closed(
    server: RosBridge, call: Callable[[int], Caller], caplog: pytest.LogCaptureFixture
) -> None:
    server.freeze()
    with caplog.at_level(logging.DEBUG, "roslibpy"):
        caller = call(server.port)
        wait_until(lambda: "Connecting to" in caplog.text)
    caller.bridge.close()
    server.thaw()
    wait_until(lambda: server.connections == 1 and not server.has_clients())
    assert caller.changes == []
    assert server.received == []


def test_another_kind_of_server_is_no_connection_and_no_error(
    call: Callable[[int], Caller],
) -> None:
    attempts: list[bytes] = []

    def refuse(listener: socket.socket) -> None:
        while len(attempts) < 3:
            client, _ = listener.accept()
            with client:
                attempts.append(client.recv(4096))
                client.sendall(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n")

    with socket.create_server(("127.0.0.1", 0)) as listener:
        threading.Thread(target=refuse, args=(listener,), daemon=True).start()
        caller = call(listener.getsockname()[1])
        wait_until(lambda: len(attempts) == 3)
    assert caller.changes == []


NONSENSE = (
    "not json",
    "[]",
    '{"no": "op"}',
    '{"op": "status", "level": "error", "msg": "no such topic"}',
    '{"op": "publish", "topic": "ready", "msg": {}}',
    '{"op": "publish", "topic": "close", "msg": {}}',
    '{"op": "publish", "topic": "error", "msg": {}}',
    '{"op": "service_response", "id": "never asked"}',
    '{"op": "call_service", "service": "/in", "args": []}',
)


def test_nonsense_from_the_server_does_no_harm(
    server: RosBridge, call: Callable[[int], Caller]
) -> None:
    caller = call(server.port)
    wait_until(lambda: server.has_subscriber("/in"))
    for nonsense in NONSENSE:
        server.send(nonsense)
        server.publish("/in", {"data": nonsense})
        wait_until(lambda sent={"data": nonsense}: sent in caller.received)  # type: ignore[misc]
    assert caller.changes == [True]
    assert caller.say("me too")


def test_a_transport_that_cannot_be_activated_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(transport: str) -> None:
        raise RuntimeError(f"Cannot activate the {transport!r} transport")

    monkeypatch.setattr("roslibpy.comm.select_factory", refuse)
    caller = Caller(9090)
    wait_until(lambda: caller.changes == [False])
    assert (
        caller.bridge.problem
        == "The connection to ROS cannot be made: Cannot activate the 'asyncio' transport"
    )
    caller.bridge.close()


PROGRAM = """
import sys, time
from sar_tui.drivers.address import Address
from sar_tui.drivers.rosbridge import Bridge
received, lost = [], []
bridge = Bridge(Address("127.0.0.1", int(sys.argv[1]), "", {}), {"/out": "std_msgs/String"},
                {"/in": ("std_msgs/String", received.append)}, lambda: lost.append(not bridge.is_connected))
bridge.open()
while not received:
    time.sleep(0.005)
bridge.publish("/out", {"data": "farewell"})
if sys.argv[2] == "politely":
    bridge.close()
    Bridge(Address("127.0.0.1", 9, "", {}), {}, {}, print).open()
print("end")
"""


@pytest.mark.parametrize("manners", ["politely", "abruptly"])
def test_a_program_prints_nothing_about_its_connection_and_ends_in_any_state_of_it(
    server: RosBridge, manners: str
) -> None:
    program = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, str(server.port), manners],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_until(lambda: server.has_subscriber("/in"))
    server.send("nonsense")
    server.leave()
    server.arrive()
    wait_until(lambda: server.has_subscriber("/in"))
    server.publish("/in", {"data": "now"})
    assert program.communicate(timeout=60) == ("end\n", "")
    assert program.returncode == 0
    if manners == "politely":
        assert server.data("/out") == ["farewell"]


def test_no_websocket_module_is_loaded_before_a_connection_is_opened() -> None:
    program = (
        "import sys, sar_tui.drivers.rosbridge, sar_tui.outputs.ros, sar_tui.inputs.ros; "
        "print(*sys.modules)"
    )
    run = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert not {"roslibpy", "autobahn", "twisted", "txaio"} & set(run.stdout.split())


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("ros://robot", Address("robot", 9090, "", {})),
        (
            "//192.0.2.7:9091/imu/data?rate=100",
            Address("192.0.2.7", 9091, "/imu/data", {"rate": "100"}),
        ),
        (" ros://[::1]:80?a=/x&b=y ", Address("::1", 80, "", {"a": "/x", "b": "y"})),
    ],
)
def test_an_address_is_parsed(text: str, expected: Address) -> None:
    assert parse(text, "ros", 9090, "ros://HOST") == expected


def test_an_invalid_address_is_refused_with_an_example() -> None:
    of_no_host = ["", "robot", "http://robot", "ros://", "ros://a b"]
    for text in [*of_no_host, "ros://robot:99999", "ros://me:secret@robot", "ros://robot?a"]:
        with pytest.raises(AddressError, match="Use ros://HOST"):
            parse(text, "ros", 9090, "ros://HOST")


def test_a_goal_gives_feedback_and_a_result_and_is_cancelled_by_another_connection(
    call: Callable[[int], Caller],
) -> None:
    with ros_bridge("slow") as server:
        first, other = call(server.port), call(server.port)
        heard: list[Any] = []
        wait_until(lambda: first.bridge.is_connected and other.bridge.is_connected)
        assert first.bridge.send_goal(
            "g1",
            "/skill/say",
            "communication_skills/action/Say",
            {"input": "Hello."},
            lambda: heard.append("begun"),
            lambda status, values: heard.append((status, values["result"]["error_code"])),
        )
        wait_until(lambda: heard == ["begun"])
        assert other.bridge.cancel_goal("g1", "/skill/say")
        wait_until(lambda: heard == ["begun", (5, 125)])
        answers: list[Any] = []
        assert first.bridge.call_service("s1", "/rosapi/action_servers", answers.append)
        wait_until(lambda: answers)
        assert "/skill/say" in answers[0]["action_servers"]

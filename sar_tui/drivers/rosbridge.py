"""A connection to a ROS system through the rosbridge protocol, with automatic reconnection."""

import logging
import threading
from collections.abc import Callable, Mapping
from typing import Annotated, Any

from msgspec import Meta

from sar_tui.drivers.address import Address
from sar_tui.drivers.installation import pip_install_extra

PORT = 9090
"""Default port of a rosbridge server."""

TopicName = Annotated[str, Meta(pattern=r"^(/[A-Za-z_][A-Za-z0-9_]*)+$")]
"""Full name of a ROS topic: ``/robot/speech``."""

FIRST_RETRY_S = 0.5
LONGEST_RETRY_S = 3.0
"""roslibpy would wait up to an hour between attempts."""
PING_S = 3.0
"""Interval of pings, and the time limit for each reply."""
CLOSE_S = 1.0
"""Longest wait for the server when closing."""
_STARTING = threading.Lock()
"""Held while roslibpy starts its event loop: a second thread would find the loop missing, and never
connect.
"""


class Bridge:
    """A connection to a rosbridge server, which is made again whenever it is lost.

    Opening and publishing never block. Messages published while there is no connection are dropped.
    After each reconnection, topics are advertised and subscribed to again. It uses roslibpy's
    asyncio transport, since the other one can be started only once in a program.

    Args:
        address: the server.
        advertised: the topics published to, with their types.
        subscribed: the topics subscribed to, with their types and the callback for each message (as
            JSON has it).
        on_change: called when the connection is made or lost, and when it is impossible (see
            ``problem``).

    All callbacks run in the connection's own thread. After ``close``, only one that was
    already under way can still run.

    Attributes:
        problem: why a connection is impossible, as a sentence; empty if it is possible.
    """

    def __init__(
        self,
        address: Address,
        advertised: Mapping[str, str],
        subscribed: Mapping[str, tuple[str, Callable[[Any], None]]],
        on_change: Callable[[], None],
    ) -> None:
        self.problem = ""
        self._address = address
        self._advertised = advertised
        self._subscribed = subscribed
        self._on_change = on_change
        self._factory: Any = None
        self._connection: Any = None
        self._thread = 0
        self._closing = threading.Lock()
        self._closed = False
        self._gone = threading.Event()

    @property
    def is_connected(self) -> bool:
        """True if the bridge is connected, as far as is known."""
        return self._connection is not None

    def open(self) -> None:
        """Connect in the background, and stay connected."""
        threading.Thread(target=self._connect, name="rosbridge", daemon=True).start()

    def publish(self, topic: str, message: Mapping[str, Any]) -> bool:
        """Send a message to an advertised topic. Returns False without a connection. May be called
        from any thread.
        """
        return self._ask("send_ros_message", {"op": "publish", "topic": topic, "msg": message})

    def send_goal(
        self,
        id: str,
        action: str,
        type: str,
        args: Mapping[str, Any],
        on_feedback: Callable[[], None],
        on_result: Callable[[int, Any], None],
    ) -> bool:
        """Send a goal to an action of ROS 2. Returns False without a connection. May be called from
        any thread.

        Args:
            id: identifies the goal; `cancel_goal` takes it.
            action, type: the action's name and type.
            args: the goal's fields. An object, as rosbridge's tests have it; its text says a list.
            on_feedback: called when the action reports anything before its result.
            on_result: called with the final status (of ``action_msgs/GoalStatus``) and the result's
                fields. Neither is called after the connection was lost.
        """
        goal = {"op": "send_action_goal", "id": id, "action": action, "action_type": type}

        def receive(result: Mapping[str, Any]) -> None:
            on_result(result["status"].value, result["values"])

        return self._ask(
            "send_ros_action_goal",
            goal | {"args": args, "feedback": True},
            self._unless_closed(receive),
            self._unless_closed(lambda _: on_feedback()),
            self._unless_closed(receive),
        )

    def cancel_goal(self, id: str, action: str) -> bool:
        """Cancel a goal, which this connection or another one has sent. Its result says when it has
        ended. Returns False without a connection.
        """
        goal = {"op": "cancel_action_goal", "id": id, "action": action}
        return self._ask("send_ros_message", goal)

    def call_service(self, id: str, service: str, on_answer: Callable[[Any], None]) -> bool:
        """Call a service that takes nothing. It may never answer. Returns False without a
        connection.
        """
        call = {"op": "call_service", "id": id, "service": service}
        answer = self._unless_closed(on_answer)
        return self._ask("send_ros_service_request", call, answer, lambda _: None)

    def _ask(
        self, method: str, message: Mapping[str, Any], *callbacks: Callable[..., None]
    ) -> bool:
        connection = self._connection
        if connection is not None:
            getattr(connection, method)(message, *callbacks)
        return connection is not None

    def close(self) -> None:
        """Send what was published, and disconnect. Waits at most a second if the bridge hangs. May
        be called twice.
        """
        with self._closing:
            self._closed = True
            if self._factory is not None:
                self._factory.maxRetries = 0
        connection, self._connection = self._connection, None
        if connection is not None:
            connection.send_close()
            if threading.get_ident() != self._thread:
                self._gone.wait(CLOSE_S)

    def _connect(self) -> None:
        try:
            from roslibpy.comm import select_factory

            make = select_factory("asyncio")
        except ImportError:
            self._refuse(no_package())
        except RuntimeError as error:
            self._refuse(f"The connection to ROS cannot be made: {error}")
        else:
            _silence("roslibpy", "autobahn")
            with _STARTING:
                factory = make(f"ws://{self._address.netloc}")
            factory.initialDelay, factory.maxDelay = FIRST_RETRY_S, LONGEST_RETRY_S
            factory.setProtocolOptions(autoPingInterval=PING_S, autoPingTimeout=PING_S)
            factory.on("ready", self._on_ready)
            factory.on("close", self._on_close)
            for topic, (_, receive) in self._subscribed.items():
                factory.on(topic, self._unless_closed(receive))
            with self._closing:
                if not self._closed:
                    self._factory = factory
                    factory.connect()

    def _refuse(self, problem: str) -> None:
        self.problem = problem
        if not self._closed:
            self._on_change()

    def _on_ready(self, connection: Any) -> None:
        self._thread = threading.get_ident()
        with self._closing:
            if self._closed:  # an attempt that was under way on closing
                connection.send_close()
                return
            for topic, kind in self._advertised.items():
                connection.send_ros_message({"op": "advertise", "topic": topic, "type": kind})
            for topic, (kind, _) in self._subscribed.items():
                connection.send_ros_message({"op": "subscribe", "topic": topic, "type": kind})
            self._connection = connection
        self._on_change()

    def _on_close(self, connection: Any) -> None:
        if self._closed:
            self._gone.set()
        elif connection is self._connection:  # otherwise a failed attempt
            self._connection = None
            self._on_change()

    def _unless_closed(self, receive: Callable[[Any], None]) -> Callable[[Any], None]:
        def guarded(message: Any) -> None:
            if not self._closed:
                receive(message)

        return guarded


def _silence(*names: str) -> None:
    """Keep loggers off the terminal. Logging that the user has set up is unaffected."""
    for name in names:
        logger = logging.getLogger(name)
        if not logger.handlers:
            logger.addHandler(logging.NullHandler())


def no_package() -> str:
    """Return the sentence that says how to install roslibpy."""
    return f"The Python package roslibpy is missing; install it with: {pip_install_extra('ros')}"

"""The message bus: typed topics and services, on one thread.

A message of an *input* topic (a key, a timer, an operator's act) begins a cascade. Handlers publish
*derived* messages, which are queued and delivered in order; the next input is delivered when the
queue is empty. So causes come before effects, and replaying the recorded inputs derives the same
messages.
"""

import threading
import traceback
from collections import deque
from collections.abc import Callable
from pathlib import PurePath
from typing import Any, Generic, Literal, NamedTuple, Protocol, TypeVar

from sar_tui.loop.clock import Clock
from sar_tui.model.messages import Fault, Message
from sar_tui.plugin_calls import PLUGIN_ERRORS, describe, inherited, line_of_error

M = TypeVar("M", bound=Message)
Q = TypeVar("Q", bound=Message)
A = TypeVar("A", bound=Message)

Origin = Literal["input", "derived", "later"]


class Topic(Generic[M]):
    """A named channel that carries one type of message.

    Args:
        name: as stored in the database and shown on graphs, e.g. ``input/key``.
        type: the message class; other classes are refused.
        origin: ``input`` for messages from outside the nodes, ``derived`` for messages that follow
            from them, ``later`` for those that are added to a record after the session, and never
            published.
        keep: new subscribers receive the last message.
        stream: high-rate data (sensor samples): its messages are not numbered, and not stored in
            ``events``.
    """

    def __init__(
        self,
        name: str,
        type: type[M],
        origin: Origin = "derived",
        *,
        keep: bool = False,
        stream: bool = False,
    ) -> None:
        self.name = name
        self.type = type
        self.origin = origin
        self.keep = keep
        self.stream = stream

    def __repr__(self) -> str:
        return f"Topic({self.name!r})"


class Service(Generic[Q, A]):
    """A named request that one node answers at once."""

    def __init__(self, name: str, request: type[Q], answer: type[A]) -> None:
        self.name = name
        self.request = request
        self.answer = answer

    def __repr__(self) -> str:
        return f"Service({self.name!r})"


FAULT = Topic("framework/fault", Fault)
"""A handler raised an exception. Declared here because the bus publishes it."""


class Record(NamedTuple):
    """A published message with its number, the time of its cascade (ns), and its topic.

    A message of a stream carries the number of the next message that is not of a stream.
    """

    seq: int
    at: int
    topic: Topic[Any]
    message: Message


class Tap(Protocol):
    """Listener to all messages, such as the recorder. It receives whole cascades, so that none is
    stored in part.
    """

    def __call__(self, cascade: list[Record]) -> None: ...


class Bus:
    """Carries messages between nodes on one thread.

    Args:
        clock: gives the time of each cascade. May be replaced between cascades, as at the end of a
            replay.
    """

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self._owner = threading.get_ident()
        self._handlers: dict[str, list[tuple[str, Callable[[Any], None]]]] = {}
        self._services: dict[str, Callable[[Any], Any]] = {}
        self._kept: dict[str, Message] = {}
        self._taps: list[Tap] = []
        self._cascade: list[Record] = []
        self._inputs: deque[tuple[Topic[Any], Message]] = deque()
        self._derived: deque[tuple[Topic[Any], Message]] = deque()
        self._running = False
        self._seq = 1
        self._now = clock.now()

    @property
    def now(self) -> int:
        """Time at which the current cascade began, in ns: the same for all its messages, and in a
        replay.
        """
        return self._now

    def count_from(self, seq: int) -> None:
        """Number the next message ``seq``, to continue the numbers of a resumed session."""
        self._seq = seq

    def last(self, topic: Topic[M]) -> M | None:
        """Return the last message of a topic that keeps it; None before the first."""
        return self._kept.get(topic.name)  # type: ignore[return-value]

    def subscribe(self, topic: Topic[M], handler: Callable[[M], None], owner: str = "") -> None:
        """Deliver ``topic`` to ``handler``, after earlier subscribers. ``owner`` is named in a
        Fault.
        """
        handler = inherited(handler)
        self._handlers.setdefault(topic.name, []).append((owner, handler))
        if topic.keep and topic.name in self._kept:
            handler(self._kept[topic.name])  # type: ignore[arg-type]

    def receivers(self, topic: Topic[Any]) -> list[object]:
        """Return the objects whose methods handle a topic, or the functions that do, in the order
        of delivery.
        """
        return [
            getattr(handler, "__self__", handler)
            for _, handler in self._handlers.get(topic.name, ())
        ]

    def serve(self, service: Service[Q, A], handler: Callable[[Q], A]) -> None:
        """Answer ``service`` with ``handler``. Raises ValueError if it is served already."""
        if service.name in self._services:
            raise ValueError(f"{service.name} is served already")
        self._services[service.name] = handler

    def tap(self, listener: Tap) -> None:
        """Pass every message to ``listener``, one complete cascade at a time."""
        self._taps.append(listener)

    def untap(self, listener: Tap) -> None:
        """Stop passing messages to ``listener``."""
        self._taps.remove(listener)

    def call(self, service: Service[Q, A], request: Q) -> A:
        """Send a request and return the answer. Exceptions of the service are raised here.

        Raises:
            TypeError: the service takes another type.
            KeyError: no node serves it.
        """
        if type(request) is not service.request:
            raise TypeError(
                f"{service.name} takes {service.request.__name__}, not {type(request).__name__}"
            )
        answer: A = self._services[service.name](request)
        return answer

    def publish(self, topic: Topic[M], message: M) -> None:
        """Publish a message on the owning thread.

        Raises:
            TypeError: the topic carries another type.
            RuntimeError: called from another thread, or a derived message outside a cascade.
        """
        if threading.get_ident() != self._owner:
            raise RuntimeError(f"{topic.name} published from another thread; use post()")
        if type(message) is not topic.type:
            raise TypeError(
                f"{topic.name} carries {topic.type.__name__}, not {type(message).__name__}"
            )
        if topic.origin == "derived":
            if not self._running:
                raise RuntimeError(
                    f"{topic.name} is derived: it can only be published while an input is handled"
                )
            self._derived.append((topic, message))
        else:
            self._inputs.append((topic, message))
            self.drain()

    def report(self, owner: str, place: str, error: BaseException) -> None:
        """Publish a Fault for an exception that was caught elsewhere, in this cascade or the
        next.
        """
        self._derived.append((FAULT, _fault(owner, place, error)))

    def post(self, topic: Topic[M], message: M) -> None:
        """Publish an input from any thread; it is delivered as soon as the owning thread is free.

        Raises:
            TypeError: the topic is not an input, or carries another type.
        """
        if topic.origin != "input" or type(message) is not topic.type:
            raise TypeError(f"{topic.name} cannot be posted with {type(message).__name__}")
        self._inputs.append((topic, message))
        self.clock.call_soon(self.drain)

    def drain(self) -> None:
        """Deliver the inputs that wait, one cascade after the other, and then faults that were
        reported outside one.
        """
        if self._running:
            return
        self._running = True
        try:
            inputs, derived, deliver = self._inputs, self._derived, self._deliver
            while inputs or derived:
                self._now = self.clock.now()
                if inputs:
                    deliver(*inputs.popleft())
                while derived:
                    deliver(*derived.popleft())
                cascade, self._cascade = self._cascade, []
                for tap in self._taps:
                    tap(cascade)
        finally:
            self._running = False

    def _deliver(self, topic: Topic[Any], message: Message) -> None:
        self._cascade.append(Record(self._seq, self._now, topic, message))
        if not topic.stream:
            self._seq += 1
        if topic.keep:
            self._kept[topic.name] = message
        for owner, handler in self._handlers.get(topic.name, ()):
            try:
                handler(message)
            except PLUGIN_ERRORS as error:
                if topic is not FAULT:
                    self._derived.append((FAULT, _fault(owner, topic.name, error)))


def _fault(owner: str, topic: str, error: BaseException) -> Fault:
    return Fault(
        node=owner,
        topic=topic,
        error=describe(error),
        place=_place(error),
        trace="".join(traceback.format_exception(error)),
    )


def _place(error: BaseException) -> str:
    """Return the last line of a task's own files that an exception passed, else the line that
    raised it: "line 12 of task.py".
    """
    raised = traceback.extract_tb(error.__traceback__)[-1]
    place = line_of_error(error) or f"{PurePath(raised.filename).name}:{raised.lineno}"
    file, _, line = place.partition(":")
    return f"line {line} of {file}"

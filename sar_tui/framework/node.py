"""A node: a list of what it hears, what it answers and what it says."""

from collections.abc import Callable
from typing import Any, ClassVar, TypeVar

from sar_tui.framework.bus import Bus, Service, Topic
from sar_tui.framework.clock import MS, Handle
from sar_tui.framework.messages import Message, TimerFired
from sar_tui.framework.topics import TIMER

STALLED = 250 * MS
"""A program that comes so late to a timer stood still meanwhile."""

F = TypeVar("F", bound=Callable[..., Any])
M = TypeVar("M", bound=Message)
Q = TypeVar("Q", bound=Message)
A = TypeVar("A", bound=Message)


def on(topic: Topic[Any]) -> Callable[[F], F]:
    """Mark a method as the handler of ``topic``."""

    def mark(method: F) -> F:
        method.hears = topic  # type: ignore[attr-defined]
        return method

    return mark


def serves(service: Service[Any, Any]) -> Callable[[F], F]:
    """Mark a method as the answerer of ``service``."""

    def mark(method: F) -> F:
        method.serves = service  # type: ignore[attr-defined]
        return method

    return mark


class Node:
    """The base of all nodes.

    A subclass names itself, declares what it ``emits`` and ``asks``, and marks its handlers with ``on`` and
    ``serves``. `sar-tui graph` draws the system from these declarations, and ``emit`` holds a node to them.
    """

    name: str
    emits: ClassVar[tuple[Topic[Any], ...]] = ()
    asks: ClassVar[tuple[Service[Any, Any], ...]] = ()

    def __init__(self) -> None:
        self._timers: dict[str, tuple[int, Handle]] = {}
        self._token = 0

    @classmethod
    def hears(cls) -> tuple[Topic[Any], ...]:
        """The topics this node handles, in the order of its methods."""
        return tuple(method.hears for method in _marked(cls, "hears"))

    @classmethod
    def answers(cls) -> tuple[Service[Any, Any], ...]:
        """The services this node answers."""
        return tuple(method.serves for method in _marked(cls, "serves"))

    def attach(self, bus: Bus) -> None:
        """Join a bus."""
        self.bus = bus
        for method in _marked(type(self), "hears"):
            bus.subscribe(method.hears, getattr(self, method.__name__), self.name)
        for method in _marked(type(self), "serves"):
            bus.serve(method.serves, getattr(self, method.__name__))

    def detach(self) -> None:
        """Let go of what the node holds outside of the bus: a device, a thread. Harmless when called again."""

    def emit(self, topic: Topic[M], message: M) -> None:
        """Publish one of the declared topics. Raises ValueError for another."""
        if topic not in self.emits:
            raise ValueError(f"{self.name} does not declare that it emits {topic.name}")
        self.bus.publish(topic, message)

    def ask(self, service: Service[Q, A], request: Q) -> A:
        """Ask one of the declared services. Raises ValueError for another."""
        if service not in self.asks:
            raise ValueError(f"{self.name} does not declare that it asks {service.name}")
        return self.bus.call(service, request)

    @property
    def now(self) -> int:
        """The time of the present cascade, in ns."""
        return self.bus.now


class TimedNode(Node):
    """A node with timers. A firing is an ordinary input message, so that a replay needs no timers at all."""

    emits: ClassVar[tuple[Topic[Any], ...]] = (TIMER,)

    def set_timer(self, name: str, due: int) -> None:
        """Have ``timer(name, late)`` called at ``due`` (ns), instead of any earlier timer of that name."""
        self.cancel_timer(name)
        self._token += 1
        fired = TimerFired(node=self.name, name=name, token=self._token, due=due)
        handle = self.bus.clock.call_at(due, lambda: self.bus.publish(TIMER, fired))
        self._timers[name] = (self._token, handle)

    def cancel_timer(self, name: str) -> None:
        """Call a timer off, if it is set."""
        if name in self._timers:
            self._timers.pop(name)[1].cancel()

    def cancel_timers(self) -> None:
        """Call all timers off."""
        for name in list(self._timers):
            self.cancel_timer(name)

    @on(TIMER)
    def timer_fired(self, fired: TimerFired) -> None:
        """Pass a firing on, unless it is another node's or was called off while it waited its turn."""
        if fired.node == self.name and self._timers.get(fired.name, (0,))[0] == fired.token:
            del self._timers[fired.name]
            self.timer(fired.name, self.now - fired.due)

    def timer(self, name: str, late: int) -> None:
        """A timer of this node fired, ``late`` ns after it was due."""


def _marked(cls: type, mark: str) -> list[Any]:
    """The methods of a class and its bases that carry ``mark``, in the order they were written."""
    methods: dict[str, Any] = {}
    for base in reversed(cls.__mro__):
        methods.update({name: value for name, value in vars(base).items() if hasattr(value, mark)})
    return list(methods.values())

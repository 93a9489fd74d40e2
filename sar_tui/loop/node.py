"""Base classes of nodes: topics they receive and emit, services they answer, timers."""

from collections.abc import Callable
from typing import Any, ClassVar, TypeVar

from sar_tui.loop.bus import Bus, Service, Topic
from sar_tui.loop.clock import Handle
from sar_tui.loop.topics import TIMER
from sar_tui.model.messages import Message, TimerFired
from sar_tui.plugin_calls import mark_methods

F = TypeVar("F", bound=Callable[..., Any])
M = TypeVar("M", bound=Message)
Q = TypeVar("Q", bound=Message)
A = TypeVar("A", bound=Message)


def on(topic: Topic[Any]) -> Callable[[F], F]:
    """Mark a method as the handler of ``topic``."""

    def mark(method: F) -> F:
        method.receives = topic  # type: ignore[attr-defined]
        return method

    return mark


def serves(service: Service[Any, Any]) -> Callable[[F], F]:
    """Mark a method as the handler of requests to ``service``."""

    def mark(method: F) -> F:
        method.serves = service  # type: ignore[attr-defined]
        return method

    return mark


class Node:
    """Base of all nodes.

    A subclass has a name, declares what it ``emits`` and ``asks``, and marks its handlers with
    ``on`` and ``serves``. `sar-tui graph` draws the system from these declarations, and ``emit``
    and ``ask`` enforce them.
    """

    name: str
    emits: ClassVar[tuple[Topic[Any], ...]] = ()
    asks: ClassVar[tuple[Service[Any, Any], ...]] = ()

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        mark_methods(cls, "node")

    @classmethod
    def receives(cls) -> tuple[Topic[Any], ...]:
        """Return the topics this node handles, in the order of its methods."""
        return tuple(method.receives for method in _marked(cls, "receives"))

    @classmethod
    def answers(cls) -> tuple[Service[Any, Any], ...]:
        """Return the services this node answers."""
        return tuple(method.serves for method in _marked(cls, "serves"))

    def attach(self, bus: Bus) -> None:
        """Subscribe to the bus."""
        self.bus = bus
        for method in _marked(type(self), "receives"):
            bus.subscribe(method.receives, getattr(self, method.__name__), self.name)
        for method in _marked(type(self), "serves"):
            bus.serve(method.serves, getattr(self, method.__name__))

    def detach(self) -> None:
        """Release resources outside the bus: a device, a thread. May be called again."""

    def emit(self, topic: Topic[M], message: M) -> None:
        """Publish a message. Raises ValueError if the topic is not declared in ``emits``."""
        if topic not in self.emits:
            raise ValueError(f"{self.name} does not declare that it emits {topic.name}")
        self.bus.publish(topic, message)

    def ask(self, service: Service[Q, A], request: Q) -> A:
        """Call a service. Raises ValueError if it is not declared in ``asks``."""
        if service not in self.asks:
            raise ValueError(f"{self.name} does not declare that it asks {service.name}")
        return self.bus.call(service, request)

    @property
    def now(self) -> int:
        """Time of the current cascade, in ns."""
        return self.bus.now


class TimedNode(Node):
    """A node with timers. A timer publishes an input message when it fires, so a replay needs no
    timers.
    """

    emits: ClassVar[tuple[Topic[Any], ...]] = (TIMER,)

    def __init__(self) -> None:
        super().__init__()
        self._timers: dict[str, tuple[int, Handle]] = {}
        self._token = 0

    def set_timer(self, name: str, due: int) -> None:
        """Call ``timer(name, late)`` at ``due`` (ns). Replaces an earlier timer of that name."""
        self.cancel_timer(name)
        self._token += 1
        fired = TimerFired(node=self.name, name=name, token=self._token, due=due)
        handle = self.bus.clock.call_at(due, lambda: self.bus.publish(TIMER, fired))
        self._timers[name] = (self._token, handle)

    def has_timer(self, name: str) -> bool:
        """Return True if a timer is set."""
        return name in self._timers

    def cancel_timer(self, name: str) -> None:
        """Cancel a timer, if it is set."""
        if name in self._timers:
            self._timers.pop(name)[1].cancel()

    def cancel_timers(self) -> None:
        """Cancel all timers."""
        for name in list(self._timers):
            self.cancel_timer(name)

    @on(TIMER)
    def timer_fired(self, fired: TimerFired) -> None:
        """Handle the firing of a timer, unless it is another node's or was cancelled meanwhile."""
        if fired.node == self.name and self._timers.get(fired.name, (0,))[0] == fired.token:
            del self._timers[fired.name]
            self.timer(fired.name, self.now - fired.due)

    def timer(self, name: str, late: int) -> None:
        """Handle a timer of this node that fired ``late`` ns after it was due."""


def _marked(cls: type, mark: str) -> list[Any]:
    """Return the methods of a class and its bases that carry ``mark``, in source order, bases
    first.
    """
    methods: dict[str, Any] = {}
    for base in reversed(cls.__mro__):
        methods.update({name: value for name, value in vars(base).items() if hasattr(value, mark)})
    return list(methods.values())

"""A fake channel of Phidget22, for sensors and motors."""

from collections.abc import Callable
from typing import Any


class PhidgetError(Exception):
    """Like Phidget22's exception: a code and two texts."""

    def __init__(self, code: int, description: str, details: str = "") -> None:
        super().__init__(code)
        self.code, self.description, self.details = code, description, details


class FakeChannel:
    """A channel whose device can be plugged in and out.

    Attributes:
        handlers: the handlers that were set, by event.
        facts: what its ``get`` methods return and its ``set`` methods change, by name.
        failing: errors of its methods, by name.
        during: functions that are called once during a method, by name.
        calls: the other calls, in order.
    """

    def __init__(self) -> None:
        self.handlers: dict[str, Any] = {}
        self.facts: dict[str, Any] = {}
        self.failing: dict[str, Exception] = {}
        self.during: dict[str, Callable[[], object]] = {}
        self.calls: list[Any] = []

    def __getattr__(self, name: str) -> Callable[..., Any]:
        def method(*arguments: Any) -> Any:
            if name in self.during:
                self.during.pop(name)()
            if name in self.failing:
                raise self.failing[name]
            if name.startswith("setOn"):
                self.handlers[name[5:-7]] = arguments[0]
            elif name.startswith("get"):
                return self.facts[name[3:]]
            else:
                self.note(name, arguments)
                if name.startswith("set"):
                    self.facts[name[3:]] = arguments[0]
            return None

        return method

    def note(self, name: str, arguments: tuple[Any, ...]) -> None:
        self.calls.append((name, arguments))

    def plug_in(self) -> None:
        self.handlers["Attach"](self)

    def pull_out(self) -> None:
        self.handlers["Detach"](self)

    def err(self, code: int, description: str) -> None:
        self.handlers["Error"](self, code, description)

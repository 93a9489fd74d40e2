"""A call of a plug-in's code that does not return is ended and named, however it is written; no
other call is.
"""

from collections.abc import Callable
from typing import Any

import pytest

from sar_tui.loop.bus import FAULT, Bus
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node, on
from sar_tui.loop.task import Task
from sar_tui.loop.topics import KEY
from sar_tui.model import messages as m
from sar_tui.model.units import SECOND
from sar_tui.outputs.node import OutputNode
from sar_tui.plugin_calls import under_way
from sar_tui.runs.plugin_watchdog import NotResponding, PluginWatchdog
from tests.facts import each
from tests.outputs.contract import THEME
from tests.outputs.fake_outputs import FakeOutput

LOOKS = 5


def watchdog() -> tuple[PluginWatchdog, list[str]]:
    given_up: list[str] = []
    return PluginWatchdog(given_up.append, limit_s=LOOKS, period_s=1), given_up


class Hanging:
    """Code that does not return: it has the watchdog look, until it is given up or ended by an
    error.

    Args:
        ignores: True if it goes on after an error.
    """

    def __init__(self, *, ignores: bool = True) -> None:
        self.dog, self.given_up = watchdog()
        self.looks = 0
        self._ignores = ignores

    def __call__(self) -> bool:
        while not self.given_up:
            try:
                self.looks += 1
                self.dog.look()
            except NotResponding:
                if not self._ignores:
                    raise
        return True


hang: Callable[[], bool]


def function() -> str:
    """Hang in a function of a module."""
    hang()
    return "module's"


def make(hangs: Callable[[], bool], keyboard: type[Task]) -> Task:
    """Return a task that hangs in every way in which a method can be written."""
    global hang  # noqa: PLW0603 - a function of a module knows no other way
    hang = hangs

    class Stubborn(keyboard):  # type: ignore[misc, valid-type]
        name = "stubborn"
        notice = lambda self, level, before: str(hang())  # noqa: E731

        def instructions(self) -> str:
            return function()

        def goal(self, level: int) -> str:
            return str([hang() for _ in range(1)])

        def measures(self, results: Any) -> Any:
            yield from iter(hang, True)

        def learning(self, attempt: Any, history: Any) -> Any:
            return (hang() for _ in range(1))

        @property
        def start_key(self) -> str:
            return function()

        @classmethod
        def sensor_seats(cls, parameters: Any) -> Any:
            return hang()

        @staticmethod
        def aside() -> str:
            return function()

    return Stubborn(keyboard.Parameters())


@pytest.mark.parametrize(
    "use",
    [
        lambda task: task.instructions(),
        lambda task: task.notice(1, 2),
        lambda task: task.goal(1),
        lambda task: list(task.measures(())),
        lambda task: list(task.learning(None, ())),
        lambda task: task.start_key,
        lambda task: type(task).sensor_seats(None),
        lambda task: task.aside(),
    ],
    ids="function lambda comprehension generator expression property class static".split(),
)
def test_a_task_that_does_not_return_is_given_up_with_its_name(
    keyboard: type[Task], use: Callable[[Any], object]
) -> None:
    hangs = Hanging()
    task = make(hangs, keyboard)
    use(task)
    assert hangs.given_up == ["task stubborn"]
    assert under_way(hangs.dog._watched) is None


class Listener(Node):
    """Hangs when it handles a key, or later, in what it gave to the bus or the clock."""

    name = "listener"

    def __init__(self, hangs: Callable[[], bool], where: str) -> None:
        super().__init__()
        self._hangs, self._where = hangs, where

    def attach(self, bus: Bus) -> None:
        super().attach(bus)
        if self._where == "subscribed":
            bus.subscribe(KEY, lambda _: self._hangs())

    @on(KEY)
    def pressed(self, _: m.KeyPressed) -> None:
        if self._where == "handler":
            self._hangs()
        elif self._where == "timer":
            self.bus.clock.call_at(self.now + SECOND, self._hangs)


@pytest.mark.parametrize("where", ["handler", "subscribed", "timer"])
def test_a_node_that_does_not_return_is_given_up_with_its_name(where: str) -> None:
    hangs = Hanging()
    clock = VirtualClock()
    bus = Bus(clock)
    Listener(hangs, where).attach(bus)
    bus.publish(KEY, m.KeyPressed(key="f", at=0))
    clock.advance(2 * SECOND)
    assert hangs.given_up == ["node listener"]


def test_a_handler_that_does_not_return_is_ended_by_an_error_of_its_node() -> None:
    hangs = Hanging(ignores=False)
    bus = Bus(VirtualClock())
    faults: list[m.Fault] = []
    bus.subscribe(FAULT, faults.append)
    Listener(hangs, "handler").attach(bus)
    bus.publish(KEY, m.KeyPressed(key="f", at=0))
    assert each(faults, "node error") == [("listener", "NotResponding: it took longer than 10 s")]
    assert hangs.looks == LOOKS + 1
    assert hangs.given_up == []
    assert under_way(hangs.dog._watched) is None


def test_calls_that_return_and_the_frameworks_own_code_are_left_alone(keyboard: type[Task]) -> None:
    dog, given_up = watchdog()
    task = make(lambda: bool(dog.look()), keyboard)
    for _ in range(2 * LOOKS):
        task.instructions()
        dog.look()
    bus = Bus(VirtualClock())
    bus.subscribe(KEY, lambda _: [dog.look() for _ in range(2 * LOOKS)])
    bus.publish(KEY, m.KeyPressed(key="f", at=0))
    assert given_up == []


def test_code_that_is_called_by_a_module_of_the_framework_itself_ends_no_watchdog() -> None:
    """As while ``outputs/node.py`` is imported: its frame has no ``self``."""
    dog, given_up = watchdog()
    imported: dict[str, Any] = {"__name__": "importlib", "look": dog.look}
    exec("def load(): look()", imported)
    exec("load()", {"__name__": "sar_tui.outputs.node", "load": imported["load"]})
    assert given_up == []


class Nameless(Node):
    """A node whose name cannot be read."""

    @property
    def name(self) -> str:  # type: ignore[override]
        raise RuntimeError("no name")

    def work(self, hangs: Callable[[], bool]) -> None:
        hangs()


def test_naming_a_plug_in_runs_none_of_its_code() -> None:
    hangs = Hanging()
    Nameless().work(hangs)
    assert hangs.given_up == ["node Nameless"]


class Stuck(FakeOutput):
    """Never returns from ``close``, unless an error ends it or it is given up."""

    def __init__(self, dog: PluginWatchdog, given_up: list[str], ignores_errors: bool) -> None:
        super().__init__("arm")
        self._dog, self._given_up, self._ignores_errors = dog, given_up, ignores_errors

    def close(self) -> None:
        while not self._given_up:
            try:
                self._dog.look()
            except NotResponding:
                if not self._ignores_errors:
                    raise


@pytest.mark.parametrize(("ignores_errors", "gone"), [(False, []), (True, ["output arm"])])
def test_an_output_that_does_not_return_is_ended_or_given_up_with_its_name(
    ignores_errors: bool, gone: list[str]
) -> None:
    dog, given_up = watchdog()
    node = OutputNode(Stuck(dog, given_up, ignores_errors), "arm", THEME)
    node.attach(Bus(VirtualClock()))
    node.detach()
    assert given_up == gone

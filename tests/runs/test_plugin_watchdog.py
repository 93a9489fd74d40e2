"""A call of a plug-in's code that does not return is ended; no other call is."""

from collections.abc import Callable
from typing import Any

import pytest

from sar_tui.framework.bus import Bus
from sar_tui.framework.clock import VirtualClock
from sar_tui.outputs.node import OutputNode
from sar_tui.runs.plugin_watchdog import NotResponding, PluginWatchdog
from tests.outputs.contract import THEME
from tests.outputs.fake_outputs import FakeOutput

LOOKS = 5


def function(module: str, body: str, **names: Any) -> Callable[[], object]:
    """Return a function of a module, such as a task's."""
    space: dict[str, Any] = {"__name__": module, **names}
    exec("def call():\n    " + body.replace("\n", "\n    "), space)
    made: Callable[[], object] = space["call"]
    return made


def watchdog() -> tuple[PluginWatchdog, list[str]]:
    given_up: list[str] = []
    return PluginWatchdog(given_up.append, limit_s=LOOKS, period_s=1), given_up


def test_a_call_that_does_not_return_is_ended_by_an_error() -> None:
    dog, given_up = watchdog()
    seen: list[int] = []

    def look() -> None:
        seen.append(1)
        dog.look()

    with pytest.raises(NotResponding, match="it took longer than 10 s"):
        function("sar_tui_tasks.loop.task", "while True: look()", look=look)()
    assert len(seen) == LOOKS + 1
    assert given_up == []


def test_a_call_that_ignores_the_error_is_given_up_with_the_name_of_its_task() -> None:
    dog, given_up = watchdog()
    body = "while not given_up:\n    try:\n        look()\n    except Exception:\n        pass"
    function("sar_tui_tasks.stubborn.task", body, look=dog.look, given_up=given_up)()
    assert given_up == ["task stubborn"]


def test_calls_that_return_and_code_that_is_no_tasks_are_left_alone() -> None:
    dog, given_up = watchdog()
    call = function("sar_tui_tasks.quick.task", "look()", look=dog.look)
    for _ in range(2 * LOOKS):
        call()
    function("another.module", f"for _ in range({2 * LOOKS}): look()", look=dog.look)()
    assert given_up == []


def test_the_time_counts_from_the_call_of_the_framework_whatever_the_task_calls_meanwhile() -> None:
    dog, _ = watchdog()
    part = function("some.library", "look()", look=dog.look)
    with pytest.raises(NotResponding):
        function("sar_tui_tasks.loop.task", "while True: part()", part=part)()


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

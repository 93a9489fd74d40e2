"""Two sensors, one for each participant: both are checked, and a lost one is reported with its
participant.
"""

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from tests.app.app_driver import AppDriver, open_app
from tests.app.test_sensor_check import Moved, Plugged

OpenCheck = Callable[..., Any]


@pytest.fixture
def open_check(data: Path, catalogue: Catalogue, monkeypatch: pytest.MonkeyPatch) -> OpenCheck:
    """Open the sensor check of a session of two with these sensors."""

    @asynccontextmanager
    async def opened(
        left: Plugged, right: Plugged, **parameters: object
    ) -> AsyncIterator[AppDriver]:
        def open_source(name: str, *, clock: VirtualClock, **__: object) -> Plugged:
            source = {"left": left, "right": right}[name]
            source.clock = clock
            return source

        monkeypatch.setattr("sar_tui.runs.sensors.open_source", open_source)
        sensors = {"respond_with": "reaches", "imu": "left", "imu_b": "right"}
        given = {**sensors, "attempts": 1, **parameters}
        plan = make_plan(catalogue, "pairs", ["P01", "P02"], given, seed=7)
        async with open_app(data, catalogue, plan) as driver:
            yield driver

    return opened


async def test_a_test_reach_is_that_of_the_checked_hand(open_check: OpenCheck) -> None:
    left, right = Moved(), Moved()
    async with open_check(left, right) as driver:
        await driver.wait(2500)
        await driver.press("tab", "t")
        await driver.wait(8000)
        assert (len(left.moves), len(right.moves)) == (0, 1)
        driver.see("✓ Reach ")
        await driver.press("tab")
        driver.lacks("✓ Reach ")
        await driver.press("z")
        assert (left.zeroed, right.zeroed) == (1, 0)


async def test_without_one_sensor_enter_asks_first(open_check: OpenCheck) -> None:
    left, right = Plugged(at_once=False), Plugged()
    async with open_check(left, right) as driver:
        await driver.wait(3500)
        driver.see("▸ On the left: P01 !", "On the right: P02 ✓")
        await driver.press("enter", "enter")
        driver.see("▸ On the right: P02 ✓")
        assert driver.screen_name == "SensorCheckScreen"
        driver.see("A sensor is missing, so the session will wait for it. Press Enter again")
        await driver.press("escape")
        assert not right.running
    assert driver.stored("SELECT id FROM sessions") == []


async def test_the_seat_of_a_detached_sensor_is_shown(open_check: OpenCheck) -> None:
    left, right = Plugged(), Plugged()
    async with open_check(left, right) as driver:
        await driver.wait(500)
        await driver.press("enter", "enter", "enter")
        driver.see("Press Enter to begin attempt 1 of 1.")
        right.unplug()
        await driver.wait(200)
        driver.see("Please wait", "Right: The sensor on your hand sends no data just now.")
        left.unplug()
        await driver.wait(200)
        driver.see("The sensor on your hand sends no data just now.")
        driver.lacks("Right: The sensor")
        right.plug()
        await driver.wait(200)
        driver.see("Left: The sensor on your hand sends no data just now.")
        left.plug()
        await driver.wait(200)
        driver.see("Press Enter to begin attempt 1 of 1.")

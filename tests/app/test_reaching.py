"""A session of reaches as its participant and the therapist see it, the hand and its sensor
simulated.
"""

import functools
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import msgspec
import pytest

from sar_tui.loop.topics import SENSOR
from sar_tui.model.messages import SensorChanged, SensorState
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from tests.app.app_driver import AppDriver, OpenSession, open_app


@asynccontextmanager
async def sit_down(data: Path, catalogue: Catalogue, **parameters: Any) -> AsyncIterator[AppDriver]:
    """Start a session of two attempts of one reach, after the sensor check."""
    settings = {"attempts": 2, "imu": "simulated", **parameters}
    async with open_app(
        data, catalogue, make_plan(catalogue, "reaching", ["P01"], settings, seed=7)
    ) as driver:
        await driver.wait(300)
        await driver.press("enter")
        driver.see("Rest your hand with the sensor at the start.")
        yield driver


@pytest.fixture
def at_the_table(data: Path, catalogue: Catalogue) -> OpenSession:
    return functools.partial(sit_down, data, catalogue)


@pytest.fixture
async def table(at_the_table: OpenSession) -> AsyncIterator[AppDriver]:
    async with at_the_table() as driver:
        yield driver


async def to_start(driver: AppDriver) -> None:
    """Continue from the instructions or a pause between attempts until a reach can be started."""
    if driver.waiting.stage == "instructions":
        await driver.wait(300)
        await driver.press("enter")
    await driver.wait(300)
    await driver.press("enter")
    await driver.wait(3000)
    assert driver.waiting.what == "start"


async def reach(driver: AppDriver) -> None:
    """Press space, let the simulated hand reach, and press space."""
    await driver.press("space")
    await come_back(driver, 2500)


async def come_back(driver: AppDriver, after_ms: float = 2300) -> None:
    """Let the simulated hand finish its reach, and press space."""
    await driver.wait(after_ms)
    await driver.press("space")
    await driver.wait(1500)


async def sensor(driver: AppDriver, state: SensorState, detail: str = "") -> None:
    """Publish a change of the sensor."""
    changed = SensorChanged(state=state, at=driver.clock.now(), detail=detail, rate_hz=250.0)
    driver.session.bus.post(SENSOR, changed)
    await driver.settle()


async def test_a_session_of_reaches(at_the_table: OpenSession) -> None:
    async with at_the_table() as driver:
        await driver.press("enter")
        driver.see("To marker 1 (15 cm) and back.", "Your goal: less than 1.20 seconds.")
        await to_start(driver)
        driver.see("Ready?", "Press Space to start.")
        assert "Reach: " not in driver.text

        await driver.press("space")
        assert [row.strip() for row in driver.rows].count("Reach: 15 cm") == 1
        driver.lacks("Ready?")
        await come_back(driver, 2400)
        assert "Reach: " not in driver.text
        driver.see("■ □")
        assert driver.waiting.stage == "attempt"
        driver.see("rad/s", " out ", " back ")  # the reach is drawn

        await to_start(driver)
        await reach(driver)
        await driver.see_the_summary()
        driver.see("goals reached")
        assert [fault.error for fault in driver.session.faults] == []
        await driver.press("enter")
        assert driver.app.return_code == 0
    assert driver.stored("SELECT status FROM sessions") == [("completed",)]
    rows = driver.stored("SELECT attempt, correct, reaction_time_ms, details FROM trials")
    found = [(attempt, correct, time) for attempt, correct, time, _ in rows]
    assert found == [(1, 1, None), (2, 1, None)]
    assert all(500 < msgspec.json.decode(details)["reach_time_ms"] < 3000 for *_, details in rows)
    assert driver.stored("SELECT sum(n) > 2000 FROM imu_chunks") == [(1,)]


async def test_who_presses_enter_is_asked_for_space(table: AppDriver) -> None:
    await table.press("enter")
    await table.wait(300)
    await table.press("space")
    table.see("Press Enter to begin attempt 1 of 2. (Space comes later.)")
    await table.press("enter")
    await table.wait(3000)
    table.see("Press Space to start.")
    table.lacks("comes later")
    await table.press("enter")
    table.see("Press Space to start. (Enter comes later.)")


async def test_a_detached_sensor_holds_the_session(table: AppDriver) -> None:
    await to_start(table)
    await table.press("space")
    assert "Reach: 15 cm" in table.text
    await table.wait(300)
    await sensor(table, "detached", "The sensor was unplugged.")
    table.see("Please wait", "The sensor was unplugged.", "The session goes on by itself")
    assert "Reach: " not in table.text
    assert "Enter" not in table.text
    await table.press("enter", "space")
    table.see("Please wait")
    await sensor(table, "attached")
    table.see("Press Space to start.")
    table.lacks("Please wait")
    await table.wait(3000)
    await reach(table)
    assert table.stored("SELECT trial, correct FROM trials") == [(1, 1)]


async def test_a_reach_that_the_sensor_missed_is_repeated(table: AppDriver) -> None:
    await to_start(table)
    await table.press("space")
    source: Any = next(node for node in table.session.nodes if node.name == "imu")
    sink = source.feed.source._sink
    await table.wait(500)
    source.feed.source._sink = lambda sample: None
    await table.wait(300)
    source.feed.source._sink = sink
    await come_back(table, 1700)
    table.see("Once more", "The sensor missed a part", "Press Space to start.")
    assert table.stored("SELECT count(*) FROM trials") == [(0,)]


async def test_a_therapist_marks_a_reach(at_the_table: OpenSession) -> None:
    async with at_the_table(reaches_per_attempt=3, attempts=1) as driver:
        await to_start(driver)
        await driver.press("space")
        await driver.wait(500)
        await driver.press("f9")
        driver.see("Marked: Assisted")
        assert "Reach: 15 cm" in driver.text, "the reach goes on"
        await come_back(driver)
        await reach(driver)
        await driver.press("f8")
        driver.see("Marked: Compensated")
        await reach(driver)
        assert driver.waiting.stage == "review"
        await driver.press("f7")
        rows = driver.stored(
            "SELECT trial, correct, json_extract(details, '$.mark') FROM trials ORDER BY trial"
        )
        assert rows == [(1, 0, "assisted"), (2, 1, "compensated"), (3, 0, "missed")]
        assert driver.stored("SELECT correct, trials, outcome FROM attempts") == [(1, 3, "failure")]
        acts = [(act["reason"], act["actor"]) for act in driver.messages("operator/act")]
        assert acts == [(mark, "therapist") for mark in ("assisted", "compensated", "missed")]
        assert not {"f7", "f8", "f9"} & {press["key"] for press in driver.messages("input/key")}


async def test_a_seed_makes_the_same_reach_again(tmp_path: Path, catalogue: Catalogue) -> None:
    stored = []
    for name in ("first", "second"):
        async with sit_down(tmp_path / name, catalogue) as driver:
            await to_start(driver)
            await reach(driver)
            stored.append(driver.stored("SELECT onset_ns, response_ns, details FROM trials"))
    assert stored[0] == stored[1]
    assert len(stored[0]) == 1


async def test_a_mark_is_replaced_by_pressing_twice(at_the_table: OpenSession) -> None:
    async with at_the_table(reaches_per_attempt=2, attempts=1) as driver:
        await to_start(driver)
        await driver.press("space")
        await driver.wait(500)
        await driver.press("f7")
        await driver.wait(300)
        await driver.press("f8", "f8")
        assert driver.sees("Marked: Marker missed · F8 again: Compensated instead"), (
            "a held key does not count twice"
        )
        await come_back(driver)
        assert driver.stored("SELECT json_extract(details, '$.mark') FROM trials") == [("missed",)]
        await driver.press("f8")
        driver.see("Marked: Compensated · Attempt 1 of 1")
        assert driver.stored("SELECT json_extract(details, '$.mark') FROM trials") == [
            ("compensated",)
        ]
        await driver.wait(300)
        await driver.press("f8")
        driver.lacks("Marked")
        await driver.wait(300)
        await driver.press("f9")
        assert driver.sees("Marked: Assisted"), "the mark was removed, so nothing is replaced"
        await driver.press("space")
        await driver.wait(500)
        assert not driver.sees("Marked"), "this is another reach"
        await driver.press("f7")
        driver.see("Marked: Marker missed")
        await come_back(driver)
        rows = driver.stored("SELECT json_extract(details, '$.mark') FROM trials ORDER BY trial")
        assert rows == [("assisted",), ("missed",)]
        assert driver.waiting.stage == "review"
        await driver.press("f7")
        assert not driver.sees("Marked"), "also after the last attempt, a removed mark disappears"


async def test_a_result_disappears_with_the_mark_that_it_followed_from(
    at_the_table: OpenSession,
) -> None:
    async with at_the_table(imu="simulated:kind=trunk-lean", least_confidence=1.0) as driver:
        await to_start(driver)
        await reach(driver)
        not_clearly = "I did not see that one clearly, so it does not count. That is all right."
        driver.see(not_clearly, "Unsure, not scored")
        for _ in range(2):
            await driver.wait(300)
            await driver.press("f6")
            driver.see("Marked: Whole reach · Attempt 1 of 2 · level 1")
            driver.lacks(not_clearly)
            said = driver.app.screen.stage.agent.words
            assert said
            await driver.wait(300)
            await driver.press("f6")
            driver.see(not_clearly, "Unsure, not scored", "Attempt 2 of 2 · level 1")
            driver.lacks(said, "G O A L")


async def test_the_marks_are_in_the_help_and_the_changes_not_in_the_footer(
    table: AppDriver,
) -> None:
    marks = "F7 Marker missed, F8 Compensated, F9 Assisted."
    await table.press("enter")
    table.lacks("F7")
    await table.press("f1")
    table.see(marks)
    await table.press("enter", "escape")
    table.lacks("F7")
    await table.press("up", "enter")
    table.see(marks)

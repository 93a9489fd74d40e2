"""A session of reaches as its participant and the therapist see it, the hand and its sensor simulated."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import msgspec
import pytest

from sar_tui.framework.messages import SensorChanged, SensorState
from sar_tui.framework.parameters import build
from sar_tui.framework.topics import SENSOR
from sar_tui.plugins import Catalogue
from sar_tui.runs import Plan
from tests.app.chair import Chair, sit_down, stored


@pytest.fixture(autouse=True)
def a_hand_that_always_moves_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    """A live session's simulated hand is another each time."""
    monkeypatch.setattr("sar_tui.app.live.secrets.randbelow", lambda most: 7)


@asynccontextmanager
async def at_the_table(data: Path, catalogue: Catalogue, **parameters: Any) -> AsyncIterator[Chair]:
    """Sit down to two attempts of one reach, the sensor looked at and found good."""
    kind = catalogue.task("reaching")
    settings = build(kind.Parameters, {"attempts": 2, "imu": "simulated", **parameters})
    async with sit_down(data, catalogue, Plan(kind, settings, "calm", "P01", seed=7)) as chair:
        await chair.wait(300)
        await chair.press("enter")
        assert chair.sees("Rest your hand with the sensor at the start.")
        yield chair


async def to_start(chair: Chair) -> None:
    """From the instructions, or from between two attempts, to where a reach can be started, the hand at rest."""
    if chair.waiting.stage == "instructions":
        await chair.wait(300)
        await chair.press("enter")
    await chair.wait(300)
    await chair.press("enter")
    await chair.wait(3000)
    assert chair.waiting.what == "start"


async def reach(chair: Chair) -> None:
    """Space, out and back by itself, space."""
    await chair.press("space")
    await chair.wait(2500)
    await chair.press("space")
    await chair.wait(1500)


async def sensor(chair: Chair, state: SensorState, detail: str = "") -> None:
    """The sensor tells of itself."""
    told = SensorChanged(state=state, at=chair.clock.now(), detail=detail, rate_hz=250.0)
    chair.session.bus.post(SENSOR, told)
    await chair.settle()


async def test_it_leads_from_the_instructions_through_reaches_to_the_summary(data: Path, catalogue: Catalogue) -> None:
    async with at_the_table(data, catalogue) as chair:
        await chair.press("enter")
        assert chair.sees("To marker 1 (15 cm) and back.")
        assert chair.sees("Your goal: less than 1.20 seconds.")
        await to_start(chair)
        assert chair.sees("Ready?")
        assert chair.sees("Rest your hand at the start. Then reach to marker 1 (15 cm) and back.")
        assert chair.sees("Press Space to start.")
        assert "Reach: " not in chair.text

        await chair.press("space")
        assert [row.strip() for row in chair.rows].count("Reach: 15 cm") == 1
        assert not chair.sees("Ready?")
        await chair.wait(2400)
        await chair.press("space")
        await chair.wait(1500)
        assert "Reach: " not in chair.text
        assert chair.sees("Reaches 1 of 1")
        assert chair.sees("Attempts 1 of 2")
        assert chair.waiting.stage == "attempt"

        await to_start(chair)
        await reach(chair)
        assert chair.sees("That was the last attempt.")
        assert chair.sees("Press Enter to see how it went.")
        await chair.see_the_summary()
        assert chair.sees("You did 2 attempts")
        await chair.press("enter")
        assert chair.app.return_code == 0
    assert stored(data, "SELECT status FROM sessions") == [("completed",)]
    rows = stored(data, "SELECT attempt, correct, reaction_time_ms, details FROM trials")
    assert [(attempt, correct, time) for attempt, correct, time, _ in rows] == [(1, 1, None), (2, 1, None)]
    assert all(500 < msgspec.json.decode(details)["reach_time_ms"] < 3000 for *_, details in rows)
    assert stored(data, "SELECT sum(n) > 2000 FROM imu_chunks") == [(1,)]


async def test_a_participant_may_take_their_time_before_each_reach(data: Path, catalogue: Catalogue) -> None:
    async with at_the_table(data, catalogue) as chair:
        await to_start(chair)
        await chair.wait(60_000)
        assert chair.sees("Press Space to start.")
        await chair.press("x", "enter")
        assert chair.sees("Press Space to start.")
        assert chair.stored("SELECT count(*) FROM trials") == [(0,)]


async def test_whoever_takes_enter_for_space_is_told_which_it_is(data: Path, catalogue: Catalogue) -> None:
    async with at_the_table(data, catalogue) as chair:
        await chair.press("enter")
        await chair.wait(300)
        await chair.press("space")
        assert chair.sees("Press Enter to begin attempt 1 of 2. (Space comes later.)")
        await chair.press("enter")
        await chair.wait(3000)
        assert chair.sees("Press Space to start.")
        assert not chair.sees("comes later")
        await chair.press("enter")
        assert chair.sees("Press Space to start. (Enter comes later.)")


async def test_a_sensor_that_comes_loose_is_told_of_and_the_session_goes_on_by_itself(
    data: Path, catalogue: Catalogue
) -> None:
    async with at_the_table(data, catalogue) as chair:
        await to_start(chair)
        await chair.press("space")
        assert "Reach: 15 cm" in chair.text
        await chair.wait(300)
        await sensor(chair, "detached", "The sensor was unplugged.")
        assert chair.sees("Please wait")
        assert chair.sees("For the experimenter: The sensor was unplugged.")
        assert chair.sees("The session goes on by itself")
        assert "Reach: " not in chair.text
        assert "Enter" not in chair.text
        await chair.press("enter", "space")
        assert chair.sees("Please wait")
        await sensor(chair, "attached")
        assert not chair.sees("Please wait")
        assert chair.sees("Press Space to start.")
        await chair.wait(3000)
        await reach(chair)
        assert chair.stored("SELECT trial, correct FROM trials") == [(1, 1)]


async def test_a_sensor_that_comes_loose_between_attempts_is_told_of_too(data: Path, catalogue: Catalogue) -> None:
    async with at_the_table(data, catalogue) as chair:
        await chair.press("enter")
        await sensor(chair, "stalled")
        assert chair.sees("Please wait")
        assert chair.sees("For the experimenter: The sensor sends nothing. Check its cable.")
        await sensor(chair, "flowing")
        assert chair.sees("Press Enter to begin attempt 1 of 2.")


async def test_a_reach_that_the_sensor_missed_is_asked_for_once_more(data: Path, catalogue: Catalogue) -> None:
    async with at_the_table(data, catalogue) as chair:
        await to_start(chair)
        await chair.press("space")
        source: Any = next(node for node in chair.session.nodes if node.name == "imu")
        sink = source.feed.source._sink
        await chair.wait(500)
        source.feed.source._sink = lambda sample: None
        await chair.wait(300)
        source.feed.source._sink = sink
        await chair.wait(1700)
        await chair.press("space")
        await chair.wait(1500)
        assert chair.sees("Once more")
        assert chair.sees("The sensor missed a part of that reach, so it does not count.")
        assert chair.sees("Press Space to start.")
        assert chair.stored("SELECT count(*) FROM trials") == [(0,)]


async def test_a_therapist_marks_the_reach_under_way_or_the_last(data: Path, catalogue: Catalogue) -> None:
    async with at_the_table(data, catalogue, reaches_per_attempt=3, attempts=1) as chair:
        await to_start(chair)
        await chair.press("space")
        await chair.wait(500)
        await chair.press("f9")
        assert chair.sees("Marked: assisted")
        assert "Reach: 15 cm" in chair.text, "the reach goes on"
        await chair.wait(2300)
        await chair.press("space")
        await chair.wait(1500)
        await reach(chair)
        await chair.press("f8")
        assert chair.sees("Marked: compensated")
        await reach(chair)
        assert chair.waiting.stage == "review"
        await chair.press("f7")
        rows = chair.stored("SELECT trial, correct, json_extract(details, '$.mark') FROM trials ORDER BY trial")
        assert rows == [(1, 0, "assisted"), (2, 1, "compensated"), (3, 0, "missed")]
        assert chair.stored("SELECT correct, trials, outcome FROM attempts") == [(1, 3, "failure")]
        acts = chair.messages("operator/act")
        assert [(act["reason"], act["actor"]) for act in acts] == [
            ("assisted", "therapist"),
            ("compensated", "therapist"),
            ("missed", "therapist"),
        ]
        assert not {"f7", "f8", "f9"} & {press["key"] for press in chair.messages("input/key")}


async def test_with_a_signal_the_screen_is_quiet_until_it_says_go(data: Path, catalogue: Catalogue) -> None:
    async with at_the_table(data, catalogue, go_signal=True, foreperiod_min_ms=900, foreperiod_max_ms=900) as chair:
        await to_start(chair)
        await chair.press("space")
        assert not chair.sees("Ready?")
        await chair.wait(1300)
        assert "Reach: " not in chair.text
        await chair.wait(200)
        assert "Reach: 15 cm" in chair.text
        await chair.wait(2300)
        await chair.press("space")
        await chair.wait(1500)
        ((correct, time),) = chair.stored("SELECT correct, reaction_time_ms FROM trials")
        assert correct
        assert 100 < time < 2000

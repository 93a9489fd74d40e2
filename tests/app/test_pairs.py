"""Two participants at one keyboard: each sees their half, turn and results."""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.loop.topics import CUE
from sar_tui.model.messages import Prompt
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import Plan, make_plan
from sar_tui.store import participants
from sar_tui.store.database import connect
from sar_tui.widgets.agent import Agent
from tests.app.app_driver import AppDriver, OpenApp
from tests.app.test_agent import count_frames

SHORT = {"attempts": 1, "prompts_per_attempt": 2}
WALL = 39
"""The column between the halves of a terminal of 80."""
Play = Callable[..., Plan]


@pytest.fixture
def play(catalogue: Catalogue) -> Play:
    def planned(policy: str, **parameters: object) -> Plan:
        settings = SHORT | {"policy": policy} | parameters
        return make_plan(catalogue, "pairs", ["P01", "P02"], settings, seed=7)

    return planned


def halves(driver: AppDriver) -> tuple[str, str]:
    """Return the left and the right half of the stage, without the plain line at the bottom."""
    stage = driver.app.screen.query_one("#prompt").region
    rows = [row.ljust(80) for row in driver.rows[stage.y : stage.bottom - 1]]
    return "\n".join(row[:WALL] for row in rows), "\n".join(row[WALL + 1 :] for row in rows)


async def press_theirs(
    driver: AppDriver, prompt: Prompt, left_ms: float = 300, right_ms: float = 500
) -> None:
    left, right = prompt.halves
    if left:
        await driver.wait(left_ms)
        await driver.press(left)
    if right:
        await driver.wait(right_ms - (left_ms if left else 0))
        await driver.press(right)


async def test_in_turn_the_letter_is_in_ones_half(opened: OpenApp, play: Play) -> None:
    async with opened(play("alternate")) as driver:
        prompt = await driver.to_first_prompt()
        assert "P01, P02" in driver.rows[0]
        left, right = halves(driver)
        assert "█" in left
        assert "█" not in right
        assert "[ Left: your turn ]" in left
        assert right.split() == ["Right"]
        driver.see(f"Left: {prompt.expected}")
        await press_theirs(driver, prompt)
        await driver.wait(600)
        left, right = halves(driver)
        assert "[ Right: your turn ]" in right, "shown before the letter comes"
        assert "█" not in left + right
        prompt = await driver.to_prompt()
        left, right = halves(driver)
        assert ("█" in left, "█" in right) == (False, True)
        assert [fault.error for fault in driver.session.faults] == []


@pytest.mark.slow
async def test_in_a_race_each_half_has_a_letter_and_its_own_results(
    opened: OpenApp, play: Play
) -> None:
    async with opened(play("race")) as driver:
        prompt = await driver.to_first_prompt()
        left, right = halves(driver)
        assert "█" in left
        assert "█" in right
        assert "turn" not in left + right
        await press_theirs(driver, prompt)
        await driver.wait(600)
        assert "Left, ahead: 1" in halves(driver)[0]
        await press_theirs(driver, await driver.to_prompt())
        await driver.wait(5000)
        assert driver.said.startswith("Left: ")
        assert "Right: " in driver.said, "the second answer stands below the first"
        await driver.see_the_summary()
        driver.see("Left (P01) 1 of 1 goals reached ● Your best: 0.30 seconds Ahead in 2 of 2.")
        driver.see("Right (P02) 1 of 1 goals reached ● Your best: 0.50 seconds Ahead in 0 of 2.")
        assert [fault.error for fault in driver.session.faults] == []
        await driver.press("enter")
    async with opened() as driver:
        await driver.press("f6")
        driver.see("Sessions of P01", "with P02")
        await driver.press("enter")
        assert driver.screen_name == "PastSessionScreen"
        driver.see("P01: You did 1 attempt", "P02: You did 1 attempt")


async def test_the_agent_looks_to_a_side_in_one_frame_and_then_is_still(
    opened: OpenApp, play: Play, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with opened(play("joint attention", cue_by="both", foreperiod_min_ms=900)) as driver:
        await driver.press("enter")
        await driver.wait(300)
        cues: list[object] = []
        driver.session.bus.subscribe(CUE, cues.append)
        await driver.press("enter")
        while driver.waiting.what != "foreperiod":
            assert driver.clock.step()
        await driver.settle()
        before = driver.text
        while not cues:
            assert driver.clock.step()
        await driver.settle()
        looking = driver.text
        assert looking != before
        assert not driver.app.screen.query_one(Agent).is_moving
        await driver.to_prompt()
        frames = count_frames(driver, monkeypatch)
        for _ in range(5):
            await driver.wait(200)
        assert frames == []
        reports = [
            one for one in driver.messages("output/report") if one["action"].startswith("cue-")
        ]
        for part in ("gaze", "gesture"):
            found = [one["state"] for one in reports if one["deed"] == part]
            assert found == ["queued", "started", "done"]


async def test_only_the_gaze_announces_the_side(opened: OpenApp, play: Play) -> None:
    async with opened(play("joint attention")) as driver:
        prompt = await driver.to_first_prompt()
        assert "your turn" in "".join(halves(driver))
        await press_theirs(driver, prompt)
        await driver.wait(600)
        assert "your turn" not in "".join(halves(driver))


async def test_home_asks_for_the_second_participant(opened: OpenApp, data: Path) -> None:
    with closing(connect(data)) as database:
        for code in ("P02", "P01"):
            participants.add(database, code)
    async with opened() as driver:
        await driver.press("right", "down")
        names = [option.id for option in driver.app.screen.query_one("#task").options]
        driver.app.screen.query_one("#task").highlighted = names.index("pairs")
        driver.app.screen.query_one("#start").press()
        await driver.settle()
        assert driver.screen_name == "SecondParticipantScreen"
        driver.see("P01 sits on the left.")
        assert [option.id for option in driver.app.screen.query_one("#others").options] == [
            "P02",
            "+",
        ]
        await driver.press("escape")
        assert driver.screen_name == "HomeScreen"
        driver.app.screen.query_one("#start").press()
        await driver.settle()
        await driver.press("down", "enter")
        assert driver.screen_name == "NewParticipantScreen"
        await driver.write(*"P09", "enter")
        assert driver.screen_name == "SessionScreen"
        found = driver.stored("SELECT seat, participant FROM seats ORDER BY seat")
        assert found == [("A", "P01"), ("B", "P09")]


@pytest.mark.parametrize(
    ("code", "turn"),
    [
        ("P01", "[ Left · P01: your turn ]"),
        ("LONG-LONG-LONG-LONGER", "[ LONG-LONG-LONG-LONGER: your turn ]"),
    ],
    ids=["beside the seat", "alone if there is no room for both"],
)
async def test_a_code_stands_over_its_half(
    opened: OpenApp, catalogue: Catalogue, code: str, turn: str
) -> None:
    plan = make_plan(catalogue, "pairs", [code, "P02"], SHORT | {"address": "code"}, seed=7)
    async with opened(plan) as driver:
        prompt = await driver.to_first_prompt()
        left, right = halves(driver)
        assert turn in left
        assert right.split() == ["Right", "·", "P02"]
        driver.see(f"{code}: {prompt.expected}")

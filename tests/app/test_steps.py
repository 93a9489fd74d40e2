"""A question between attempts on the participant's screen."""

import re
from contextlib import closing
from pathlib import Path

import pytest
from msgspec.structs import replace

from sar_tui.app.screens.waiting_text import decline_text, step_text
from sar_tui.loop.task import Task
from sar_tui.model.language import Language
from sar_tui.model.messages import AskedStep
from sar_tui.model.step import Entry, Step
from sar_tui.plugins import Catalogue
from sar_tui.replay.replay import replay
from sar_tui.rules.questions import EARLIER, QUESTIONS
from sar_tui.runs.plan import make_plan
from sar_tui.store import sessions
from sar_tui.store.database import connect
from sar_tui.widgets.answer_options import SMALLEST_SCALE
from tests.app.app_driver import OpenApp, OpenSession, plan, stored
from tests.recorded import said

ENGLISH = Language()
EMPTY = Entry()
PLACES = Step(name="where", text="Where?", kind="choices", labels=("hand", "arm"))


def shown(step: Step, entry: Entry = EMPTY, columns: int = SMALLEST_SCALE) -> list[str]:
    text = step_text(AskedStep(number=1, step=step, entry=entry), ENGLISH, columns=columns)
    return [text.headline, *text.text.replace("\u00a0", " ").split("\n"), text.press]


async def test_a_question_is_answered_on_the_screen(open_session: OpenSession) -> None:
    async with open_session(
        attempts=1, prompts_per_attempt=1, questions=("pain", "exertion", "remark")
    ) as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        await driver.wait(1500)
        driver.see("How strong is your pain now?", "Press Tab if you would rather not say.")
        await driver.press("enter")
        driver.see("Please choose first")
        await driver.press("5")
        driver.see("┃ 5 ┃")
        await driver.press("enter")
        driver.see("How hard was that for you?")
        await driver.wait(500)
        await driver.press("tab")
        driver.see("Is there anything you would like to tell us?")
        await driver.wait(500)
        await driver.press("o", "k", "enter")
        driver.see("All done")
    assert driver.stored("SELECT step, status, answer FROM answers ORDER BY number") == [
        ("pain", "answered", "5"),
        ("exertion", "declined", None),
        ("remark", "answered", '"ok"'),
    ]


@pytest.mark.parametrize(("key", "status"), [("enter", "ended"), ("g", "paused")])
async def test_too_much_pain_between_attempts_leads_to_the_advice_to_stop(
    open_session: OpenSession, data: Path, key: str, status: str
) -> None:
    async with open_session(
        prompts_per_attempt=1, questions=("pain",), questions_every=1
    ) as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        await driver.wait(1500)
        driver.see("How strong is your pain now?")
        await driver.press("9", "enter")
        driver.see("Please stop for today Rest, and tell your therapist about the pain now.")
        assert driver.waiting.reason == "pain"
        await driver.press(key)
        assert driver.waiting.stage == status
    advice = "stopped" if key == "enter" else "went on"
    with closing(connect(data)) as database:
        assert ("pause", "pain", 9, advice) in said(database)


CONSENT = Step(
    name="consent", kind="choice", text="Do you agree?", labels=("yes", "no"), before=True,
    required="yes",
)  # fmt: skip


async def test_without_consent_no_session_begins(
    opened: OpenApp, data: Path, catalogue: Catalogue
) -> None:
    settings = {"attempts": 1, "imu": "simulated", "ask_wellbeing": True}
    asked = make_plan(catalogue, "reaching", ["P01"], settings, seed=7, steps=(CONSENT,))
    async with opened(asked) as driver:
        await driver.press("0", "enter", "1", "enter")
        await driver.wait(300)
        await driver.press("enter")
        await driver.wait(2000)
        await driver.press("enter")
        driver.see("Do you agree?")
        assert stored(data, "SELECT count(*) FROM records") == [(2,)]
        await driver.wait(500)
        await driver.press("2", "enter")
        await driver.wait(500)
        driver.see("That is all right", "The session does not begin")
        await driver.press("enter")
        assert driver.app.return_code == 0, "nothing more is asked"
        session = driver.session_id
    assert stored(data, "SELECT status FROM sessions") == [("refused",)]
    assert stored(data, "SELECT step, status, answer FROM answers") == [
        ("consent", "answered", '"no"')
    ]
    for table in ("records", "imu_chunks", "trials", "attempts"):
        assert stored(data, f"SELECT count(*) FROM {table}") == [(0,)], table
    with closing(connect(data)) as database:
        assert replay(database, data, catalogue, sessions.find(database, data, session)).identical


async def test_a_consent_that_was_interrupted_is_asked_again(
    opened: OpenApp, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    planned = replace(plan(catalogue, keyboard), steps=(CONSENT,))
    async with opened(planned) as driver:
        await driver.press("enter")
        driver.see("Do you agree?")
        session = driver.session_id
    async with opened(session) as driver:
        await driver.press("enter")
        driver.see("Do you agree?")
        await driver.wait(500)
        await driver.press("tab")
        await driver.wait(500)
        driver.see("That is all right")
    assert driver.stored("SELECT status FROM sessions") == [("refused",)]
    assert driver.stored("SELECT step, status FROM answers") == [("consent", "declined")]


def test_the_numbers_of_a_scale_stand_above_the_words_at_its_ends() -> None:
    headline, above, row, _, ends, _ = shown(QUESTIONS["pain"], Entry(chosen=(3,)))
    assert headline == "How strong is your pain now?"
    assert re.findall(r"\d+", row) == [str(n) for n in range(11)]
    assert above.index("┏") == row.index("┃3 ┃"), "the chosen one has a heavy border"
    assert ends.startswith("no pain")
    assert ends.endswith("worst pain imaginable")


def test_borgs_scale_fits_on_a_small_screen() -> None:
    _, *rows, how = shown(EARLIER["effort"], Entry(chosen=(2,)), columns=78)
    assert len(rows) == 6
    assert max(map(len, rows)) <= 68
    assert "▶ 0.5  extremely weak" in rows[2]
    assert how.endswith("Press Tab if you would rather not say.")


def test_options_are_ticked_and_the_cursor_points_at_one() -> None:
    _, *rows, _ = shown(PLACES, Entry(chosen=(1,), place=0))
    assert [row.strip() for row in rows] == ["▶ [ ] 1  hand", "[x] 2  arm"]


@pytest.mark.parametrize(("place", "at"), [(None, -1), (0, 1), (100, 51)])
def test_a_mark_stands_on_a_line_once_it_is_placed(place: int | None, at: int) -> None:
    line = shown(Step(name="a", text="A", kind="line"), Entry(place=place), columns=78)[1]
    assert line.find("●") == at


def test_a_screen_to_read_needs_no_answer() -> None:
    step = Step(name="a", text="Next comes the harder part.")
    assert shown(step) == ["", "Next comes the harder part.", "Press Enter to go on."]
    assert decline_text(step, ENGLISH) == ""


def test_a_calibration_tells_the_time_that_is_left() -> None:
    step = Step(name="a", text="Keep still.", kind="calibration", seconds=3)
    found = step_text(AskedStep(number=1, step=step), ENGLISH, 2_500_000_000).text
    assert found == "We go on in 3 seconds."

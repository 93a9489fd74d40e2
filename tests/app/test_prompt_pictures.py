"""Sessions whose prompts have pictures and colours: all they need is there before they begin."""

from pathlib import Path

import pytest
from PIL import Image
from textual.geometry import Region

from sar_tui.app.app import SarTui
from sar_tui.app.prompt_needs import NO_COLOR
from sar_tui.loop.prompt_colors import OKABE_ITO
from sar_tui.loop.topics import PROMPT
from sar_tui.widgets.big_prompt import BigPrompt
from sar_tui.widgets.prompt_pictures import no_package
from tests.app.app_driver import OpenSession
from tests.documented import write_documented
from tests.edit import edit

COLOURED = """
from sar_tui.loop.task import Task
from sar_tui.model.trial_types import Metric, Result, Stimulus


class Coloured(Task):
    name = "coloured"
    title = "Coloured"
    metric = Metric("reaction_time", "ms", "lower")

    def instructions(self):
        return "Press the first letter of the ink's colour."

    def perceived(self, trial, percept):
        return Result(correct=percept.key == trial.stimulus.expected, response=percept.key, response_at=percept.at)

"""
SIDES = """
    def stimulus(self, situation):
        return Stimulus("right", "r", "Which side?", halves=("", "●"), colour="COLOUR")
"""


@pytest.fixture
def naming(tmp_path: Path) -> Path:
    """The documented task, with its pictures."""
    folder = write_documented(tmp_path / "mytasks", "naming")
    (folder / "pictures").mkdir()
    for name, color in (("apple", "red"), ("banana", "yellow")):
        Image.new("RGB", (60, 40), color).save(folder / "pictures" / f"{name}.png")
    return folder


def coloured(folder: Path, stimulus: str) -> Path:
    """Write a task with these prompts."""
    task = folder / "mytasks" / "coloured"
    task.mkdir(parents=True)
    (task / "task.py").write_text(COLOURED + stimulus, encoding="utf-8")
    return task


@pytest.fixture
def half_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """A terminal that shows pictures in half blocks."""
    monkeypatch.setattr(SarTui, "picture_way", "half blocks")


@pytest.mark.usefixtures("half_blocks")
async def test_a_picture_is_prepared_before_its_prompt_and_drawn_with_its_text(
    open_task: OpenSession, naming: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with open_task(naming, attempts=1) as driver:
        await driver.press("enter")
        order: list[str] = []
        driver.session.bus.subscribe(PROMPT, lambda _: order.append("prompt"))
        opened = Image.open
        monkeypatch.setattr(Image, "open", lambda *how: (order.append("read"), opened(*how))[1])
        await driver.press("enter")
        await driver.wait(1300)  # the agent is done, and the foreperiod has begun
        assert order == ["read"]
        prompt = await driver.to_prompt()
        assert order == ["read", "prompt"]
        assert "▀" * 20 in driver.text
        driver.see("What is it?")
        assert prompt.picture == f"pictures/{prompt.stimulus}.png"
        assert [each["picture"] for each in driver.messages("screen/shown")] == ["half blocks"]
        await driver.press(prompt.expected)
        assert "▀" not in driver.text
        assert driver.session.faults == []


@pytest.mark.usefixtures("half_blocks")
async def test_a_missing_picture_is_replaced_by_its_glyph(
    open_task: OpenSession, naming: Path
) -> None:
    async with open_task(naming, attempts=1) as driver:
        for picture in (naming / "pictures").iterdir():
            picture.unlink()
        prompt = await driver.to_first_prompt()
        assert any(block in driver.text for block in "█▀▄"), "its name, in large letters"
        await driver.press(prompt.expected)
        (timing,) = driver.stored("SELECT timing FROM trials")
        assert "no_picture" in timing[0]
        assert driver.session.faults == []


@pytest.mark.usefixtures("half_blocks")
async def test_pictures_of_frames_are_prepared_and_drawn(
    open_task: OpenSession, naming: Path
) -> None:
    picture = 'picture=f"pictures/{thing}.png"'
    edit(naming / "task.py", "import Metric", "import Frame, Metric")
    edit(naming / "task.py", 'text="What is it?"', 'text="Naming"')
    frames = f'frames=(Frame("+", 200), Frame(text="What is it?", {picture}))'
    edit(naming / "task.py", picture, frames)
    async with open_task(naming, attempts=1) as driver:
        prompt = await driver.to_first_prompt()
        driver.lacks("What is it?")
        await driver.wait(250)
        driver.see("What is it?")
        assert "▀" * 20 in driver.text
        await driver.press(prompt.expected)
        found = [(each["frame"], each["picture"]) for each in driver.messages("screen/shown")]
        assert found == [(0, ""), (1, "half blocks")]
        assert driver.session.faults == []


async def refusal(open_task: OpenSession, folder: Path) -> str:
    """The sentence with which the app ends instead of beginning a session."""
    async with open_task(folder, attempts=1) as driver:
        assert driver.app.live is None
        return driver.app.failure


async def test_a_session_does_not_begin_without_its_pictures(
    open_task: OpenSession, naming: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (naming / "pictures" / "banana.png").write_bytes(b"no picture")
    found = await refusal(open_task, naming)
    assert found == "The picture banana.png cannot be read (UnidentifiedImageError)."
    (naming / "pictures" / "banana.png").unlink()
    assert (
        await refusal(open_task, naming) == f"There is no picture pictures/banana.png in {naming}."
    )
    monkeypatch.setattr("sar_tui.app.prompt_needs.has_pictures_extra", lambda: False)
    assert await refusal(open_task, naming) == no_package()


async def test_no_session_begins_with_a_picture_from_elsewhere(
    open_task: OpenSession, naming: Path
) -> None:
    edit(naming / "task.py", 'f"pictures/', 'f"../')
    assert "is outside the task's folder" in await refusal(open_task, naming)


async def test_documented_prompts_have_the_colours_that_they_name(
    open_task: OpenSession, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLORTERM", "truecolor")
    async with open_task(write_documented(tmp_path / "mytasks", "stroop"), attempts=1) as driver:
        prompt = await driver.to_first_prompt()
        word, ink = prompt.stimulus.split(" in ")
        assert (prompt.glyph, prompt.colour, prompt.expected) == (word.upper(), ink, ink[0])
        drawn = [
            segment
            for strip in driver.app.screen.query_one(BigPrompt).render_lines(Region(0, 0, 80, 14))
            for segment in strip
            if set(segment.text) & set("█▀▄")
        ]
        styles = {
            segment.style.color.triplet.hex
            for segment in drawn
            if segment.style and segment.style.color
        }
        assert styles == {OKABE_ITO[ink]}
        await driver.press(prompt.expected)
        assert driver.stored("SELECT correct FROM trials") == [(1,)]
        assert driver.session.faults == []


async def test_a_session_with_colours_begins_only_where_there_are_colours(
    open_task: OpenSession, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pink = coloured(tmp_path / "pink", SIDES.replace("COLOUR", "pink"))
    assert "There is no colour 'pink'" in await refusal(open_task, pink)
    monkeypatch.setenv("NO_COLOR", "1")
    found = await refusal(open_task, coloured(tmp_path / "blue", SIDES.replace("COLOUR", "blue")))
    assert found == NO_COLOR


async def test_a_plain_prompt_is_stored_as_before(open_task: OpenSession, tmp_path: Path) -> None:
    async with open_task(coloured(tmp_path, SIDES.replace("COLOUR", "")), attempts=1) as driver:
        await driver.to_first_prompt()
        await driver.press("r")
        ((stored,),) = driver.stored(
            "SELECT m.message FROM messages m JOIN topics t ON m.topic=t.id WHERE "
            "t.name='event_handler/prompt' LIMIT 1"
        )
        assert not stored.rstrip("]").endswith('""')

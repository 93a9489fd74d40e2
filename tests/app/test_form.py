"""A participant fills in a form, alone on the screen, with keys, a switch, or a voice."""

from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.records import kind as kinds_room
from sar_tui.records.kind import Kind, find
from sar_tui.store import records
from sar_tui.store.forms import FormAnswers, Occasion
from sar_tui.store.records import Record
from tests.app.app_driver import AppDriver, OpenApp, given, known
from tests.app.test_progress import open_progress, trained
from tests.app.test_read_aloud import Listener, Transcript, transcript
from tests.app.test_switch import OneSwitch

__all__ = ["transcript"]

OWN = """
name = "own"
title = "About you"
entered_by = "participant"
[form]
[[fields]]
name = "age"
title = "How old are you?"
hint = "in years"
type = "integer"
lowest = 18
highest = 120
[[fields]]
name = "hand"
title = "Which hand do you write with?"
type = "choice"
labels = ["left", "right"]
[[fields]]
name = "mood"
title = "How are you?"
type = "integer"
lowest = 0
highest = 100
labels = ["bad", "good"]
[[fields]]
name = "remark"
title = "Anything else?"
type = "text"
[[fields]]
name = "often"
title = "How often?"
type = "integer"
lowest = 0
highest = 3
labels = ["never", "sometimes", "often", "always"]
[words.de]
items = ["Wie alt?", "Welche Hand?", "Wie geht es?", "Noch etwas?", "Wie oft?"]
ends = [[], ["links", "rechts"], [], [], []]
"""


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Kind:
    """A form of a laboratory, with items of all types."""
    monkeypatch.setattr(kinds_room, "own_folder", lambda: tmp_path)
    (tmp_path / "own.toml").write_text(OWN, encoding="utf-8")
    kinds_room._read_folder.cache_clear()
    return find("own")


Filled = Callable[..., AbstractAsyncContextManager[AppDriver]]


@pytest.fixture
def fill(opened: OpenApp, data: Path) -> Filled:
    """Open the app, and a form in it."""

    @asynccontextmanager
    async def filling(
        kind: str = "SUS", language: str = "", **how: Any
    ) -> AsyncIterator[AppDriver]:
        async with opened(**how) as driver:
            driver.app.fill_form(find(kind), Occasion("P01"), lambda _: None, language)
            await driver.settle()
            await driver.wait(700)
            yield driver

    return filling


def stored(driver: AppDriver, kind: str = "SUS") -> Record:
    (found,) = records.listing(driver.app.database, kinds=(kind,))
    return found


async def test_a_form_is_filled_in_with_digits_and_its_score_is_stored(
    fill: Filled, data: Path
) -> None:
    known(data)
    async with fill() as driver:
        driver.see("System Usability Scale", "Item 1 of 10", "I think that I would like to use")
        driver.see(
            "Strongly disagree",
            "Press Tab if you would rather not say.",
            "Press the number or an arrow key, then Enter.",
        )
        driver.lacks("Ctrl-P", "Ctrl-Q", "You said")
        await driver.press("enter")
        driver.see("Please choose first, then press Enter.")
        assert driver.stored("SELECT count(*) FROM records") == [(0,)], "nothing is preselected"
        await driver.press("6", "4")
        driver.see("Press Enter to go on.")
        await driver.press("enter")
        driver.see("Item 2 of 10", "You said: 4. Backspace goes back.")
        await driver.press("right", "right", "enter", "backspace")
        assert stored(driver).content["q2"] == 2
        await driver.press("1", "enter", "tab", *given(*"1515151"))
        driver.see("Thank you", "Everything is saved.", "Press Enter to finish.")
        found = stored(driver)
        assert (found.content["score"], found.content["score_missing"]) == (92.5 - 0, 1)
        assert found.content["q3"] == "not said"
        await driver.press("enter")
        assert driver.screen_name == "HomeScreen"
        driver.see("P01")


@pytest.mark.slow
async def test_an_answer_is_changed_from_the_thanks_and_counts_once(
    fill: Filled, data: Path
) -> None:
    known(data)
    async with fill("effort") as driver:
        driver.lacks("Item 1")
        await driver.press("7", "enter")
        driver.see("Thank you")
        assert stored(driver, "effort").content["score"] == 7
        await driver.press("backspace")
        driver.see("┃ 7 ┃", "Press Enter to go on.")
        await driver.press("3", "enter", "enter")
        assert stored(driver, "effort").content["score"] == 3
        assert driver.screen_name == "HomeScreen"


@pytest.mark.slow
async def test_the_time_of_each_item_is_kept_and_adds_up(
    fill: Filled, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    known(data)
    now = [0]
    async with fill() as driver:
        filling = driver.app.screen._interview
        filling._now = lambda: now[0] * 1_000_000
        filling._shown = 0
        now[0] = 1500
        await driver.press("2", "enter")
        assert stored(driver).content["q1_ms"] == 1500
        await driver.press("backspace")
        now[0] = 1900
        await driver.press("3", "enter")
        assert stored(driver).content["q1_ms"] == 1900


async def test_a_form_that_was_left_goes_on_the_same_day_and_begins_anew_on_another(
    fill: Filled, data: Path
) -> None:
    known(data)
    async with fill() as driver:
        await driver.press(*given("3", "3"), "escape", "escape", "escape")
        assert driver.screen_name == "HomeScreen"
        assert stored(driver).content["status"] == "open"
        driver.app.fill_form(find("SUS"), Occasion("P01"), lambda _: None)
        await driver.settle()
        driver.see("Item 3 of 10", "You said: 3.")
        await driver.press("escape", "escape", "escape")
        await driver.wait(700)
        before = (datetime.now(UTC) - timedelta(days=2)).isoformat()
        with driver.app.database:
            driver.app.database.execute("UPDATE records SET at=?", (before,))
        driver.app.fill_form(find("SUS"), Occasion("P01"), lambda _: None)
        await driver.settle()
        driver.see("Item 1 of 10")
        driver.app.screen.dismiss(None)
        await driver.settle()
        driver.app.fill_form(find("SUS"), Occasion("P01", moment="after"), lambda _: None)
        await driver.settle()
        driver.see("Item 1 of 10")


@pytest.mark.usefixtures("own")
async def test_items_of_all_types_are_answered(fill: Filled, data: Path) -> None:
    known(data)
    async with fill("own") as driver:
        driver.see("How old are you?", "in years", "Type your answer, then press Enter.")
        await driver.press("1", "7", "enter")
        driver.see("How old are you? lies within 18 to 120, not at 17.")
        await driver.press("backspace", "backspace", "?", "enter")
        driver.see("How old are you? is a number, not '?'.")
        await driver.press("backspace", "4", "2", "enter")
        driver.see("Which hand do you write with?", "1 left", "You said: 42.")
        await driver.press("2", "enter")
        driver.see("How are you?", "bad", "good", "Move the mark with the arrow keys")
        await driver.press("5", "right", "enter")
        driver.see("Anything else?", "You said: 51.")
        await driver.press("N", "o", "!", "enter")
        driver.see("How often?", "0 never", "3 always")
        await driver.press("0", "enter")
        driver.see("Thank you")
        content = stored(driver, "own").content
        assert [content[name] for name in ("age", "hand", "mood", "remark", "often")] == [
            42, "right", 51, "No!", 0,
        ]  # fmt: skip
        await driver.press("backspace", "backspace")
        driver.see("No!")
        await driver.press("backspace", "backspace", "backspace", "backspace")
        driver.see("How are you?", "You said: right.")


@pytest.mark.usefixtures("own")
async def test_a_choice_is_stored_in_the_words_of_its_declaration(fill: Filled, data: Path) -> None:
    known(data)
    async with fill("own", "de") as driver:
        driver.see("Frage 1 von 5", "Wie alt?")
        await driver.press("9", "enter")
        driver.see("Wie alt? liegt")
        await driver.press("0", "enter", "1", "enter")
        driver.see("Wie geht es?", "links")
        content = stored(driver, "own").content
        assert (content["hand"], content["language"]) == ("left", "de")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("language", "words"),
    [
        ("de", ("Wie anstrengend war das für Sie?", "so anstrengend wie nur möglich", "Vielen Dank")),
        ("es", ("¿Cuánto esfuerzo ha sido?", "todo el esfuerzo posible", "Muchas gracias")),
    ],
)  # fmt: skip
@pytest.mark.parametrize("size", [(80, 24), (160, 48)])
async def test_a_form_speaks_the_language_of_the_participant(
    fill: Filled, data: Path, language: str, words: tuple[str, str, str], size: tuple[int, int]
) -> None:
    known(data, language=language)
    async with fill("effort", size=size) as driver:
        *asked, thanks = words
        question, end = asked
        driver.see(*((question, end) if size[0] == 80 else (end,)))
        await driver.press("4", "enter")
        if size[0] == 80:
            driver.see(thanks)
        assert stored(driver, "effort").content["language"] == language


@pytest.mark.slow
@pytest.mark.usefixtures("own")
@pytest.mark.parametrize("kind", ["SUS", "NASA-TLX", "own"])
async def test_nothing_is_cut_off_at_80_by_24(fill: Filled, data: Path, kind: str) -> None:
    known(data)
    async with fill(kind) as driver:
        for number, item in enumerate(find(kind).items, 1):
            driver.see(f"Item {number} of", item.title, *item.labels)
            driver.see("Press Tab if you would rather not say.", "Esc Back")
            for part in driver.app.screen.query("#questions > *"):
                assert not part.display or part.region.bottom <= driver.app.size.height - 2, part
                assert part.region.y >= 1 or not part.display
            await driver.press("tab")
        driver.see("Thank you")


LONG = """
name = "long"
title = "Long"
entered_by = "participant"
[form]
[[fields]]
name = "understood"
title = "When you think of the last two weeks, how often did you feel that the robot understood you?"
type = "choice"
labels = ["a", "b", "c", "d", "e", "f", "g", "h", "The last option, which says more than a line has room for."]
[[fields]]
name = "word"
title = "Which word?"
type = "integer"
lowest = 0
highest = 20
labels = {labels}
[[fields]]
name = "typed"
title = "How many?"
type = "integer"
lowest = 0
highest = 50
labels = ["none", "all"]
[words.en]
instruction = "Please think of the last two weeks, and answer as honestly as you can."
""".replace("{labels}", f"{[f'word number {number}' for number in range(21)]}")  # fmt: skip


@pytest.fixture
def long(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Kind:
    """A form whose items are longer than a small window."""
    monkeypatch.setattr(kinds_room, "own_folder", lambda: tmp_path)
    (tmp_path / "long.toml").write_text(LONG, encoding="utf-8")
    kinds_room._read_folder.cache_clear()
    return find("long")


@pytest.mark.usefixtures("long")
async def test_what_is_chosen_is_in_sight_in_a_window_that_is_too_small(
    fill: Filled, data: Path
) -> None:
    known(data)
    async with fill("long", size=(40, 12)) as driver:
        driver.see("When you think of")
        await driver.press("9")
        driver.see("▶ 9 The last option", "Press Enter to go on.")
        await driver.press("1")
        driver.see("▶ 1 a")
        await driver.press("pageup")
        await driver.settle()
        driver.see("When you think of")
        await driver.press("enter")
        driver.see("Which word?")
        await driver.press("left")
        driver.see("▶ 20 word number 20")
        await driver.press("enter", "6", "0", "enter")
        driver.see("lies within")


@pytest.mark.usefixtures("long")
async def test_long_options_and_the_range_of_a_number_are_shown(fill: Filled, data: Path) -> None:
    known(data)
    async with fill("long") as driver:
        await driver.press("1", "enter")
        rows = [row for row in driver.rows if "word\N{NO-BREAK SPACE}number" in row]
        assert len(rows) == 7, "three columns"
        await driver.press("tab")
        driver.see("0 to 50 (none – all)")


async def test_a_form_that_was_changed_meanwhile_begins_anew(
    fill: Filled, data: Path, own: Kind, tmp_path: Path
) -> None:
    known(data)
    async with fill("own") as driver:
        await driver.press("4", "2", "enter", "2", "enter")
        driver.see("Item 3 of 5")
    changed = OWN.replace('labels = ["left", "right"]', 'labels = ["left", "both"]')
    (tmp_path / "own.toml").write_text(changed, encoding="utf-8")
    kinds_room._read_folder.cache_clear()
    async with fill("own") as driver:
        driver.see("Item 1 of 5")
        await driver.press("4", "2", "enter")
        driver.see("Item 2 of 5")
        assert len(records.listing(driver.app.database, kinds=("own",))) == 2


@pytest.mark.usefixtures("own")
async def test_a_form_goes_on_in_the_language_in_which_it_was_begun(
    fill: Filled, data: Path
) -> None:
    known(data)
    async with fill("own", language="de") as driver:
        await driver.press("4", "2", "enter")
    async with fill("own") as driver:
        driver.see("Welche Hand?", "Zurück")
        await driver.press("1", "enter")
        assert stored(driver, "own").content["language"] == "de"


BIPOLAR = """
name = "bipolar"
title = "Bipolar"
entered_by = "participant"
[form]
items = 1
lowest = -3
highest = 3
[[scores]]
[words.en]
items = ["How was it?"]
labels = ["bad", "good"]
"""


@pytest.mark.parametrize("size", [(80, 24), (160, 48)])
async def test_a_scale_has_points_below_zero(
    fill: Filled, data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, size: tuple[int, int]
) -> None:
    monkeypatch.setattr(kinds_room, "own_folder", lambda: tmp_path)
    (tmp_path / "bipolar.toml").write_text(BIPOLAR, encoding="utf-8")
    kinds_room._read_folder.cache_clear()
    known(data)
    async with fill("bipolar", size=size) as driver:
        await driver.wait(700)
        await driver.strike("-", "2")
        driver.see("Press Enter to go on.")
        await driver.press("enter")
        assert stored(driver, "bipolar").content["score"] == -2


async def test_a_form_that_is_left_after_its_last_answer_is_complete(
    opened: OpenApp, data: Path
) -> None:
    known(data)
    ended: list[Record | None] = []
    async with opened() as driver:
        driver.app.fill_form(find("effort"), Occasion("P01"), ended.append)
        await driver.settle()
        await driver.wait(700)
        await driver.press("7", "enter", "escape", "escape")
        assert driver.screen_name == "HomeScreen"
    (found,) = ended
    assert found is not None
    assert found.content["score"] == 7


async def test_the_same_answer_at_once_is_no_error(fill: Filled, data: Path) -> None:
    known(data)
    async with fill("SUS") as driver:
        answers = FormAnswers(driver.app.database, find("SUS"), Occasion("P01"))
        item = find("SUS").items[0]
        answers.answer(item, 4, 0)
        answers.answer(item, 4, 0)
        assert stored(driver).version == 1


async def test_a_form_is_filled_in_with_one_switch(fill: Filled, data: Path) -> None:
    known(data, switch="one", task="gonogo")
    async with fill("pain-now") as driver:
        person = OneSwitch(driver)
        driver.lacks("Press Tab if you would rather not say.")
        await person.choose("4", "Yes", "Back", "2", "Yes", "Finish")
        assert stored(driver, "pain-now").content["score"] == 2
        assert driver.screen_name == "HomeScreen"
        assert driver.app.switch is None, "the keys are the therapist's again"


async def test_a_form_is_read_aloud(fill: Filled, data: Path, transcript: Transcript) -> None:
    known(data, outputs=["screen", "speech"], read_aloud=True)
    async with fill() as driver:
        listener = Listener(driver, transcript)
        await listener.hear([])
        for key in given(*"1234"):
            await listener.press(key)
        assert listener.count > 12
        await driver.press("escape", "escape", "escape", "escape", "escape")
        assert not driver.app.aloud.is_on


async def test_a_file_of_a_form_that_cannot_be_read_stops_nothing_else(
    opened: OpenApp, data: Path, catalogue: Catalogue, own: Kind, tmp_path: Path
) -> None:
    trained(data, catalogue, 1000, 1000)
    (tmp_path / "own.toml").write_text('name = "own', encoding="utf-8")
    kinds_room._read_folder.cache_clear()
    async with opened() as driver:
        await open_progress(driver, catalogue)
        await driver.press("a", "enter")
        driver.see("effort · Effort")
        driver.lacks("own · About you")


@pytest.mark.slow
async def test_a_therapist_hands_over_a_form_from_the_records(
    opened: OpenApp, data: Path, catalogue: Catalogue
) -> None:
    trained(data, catalogue, 1000)
    async with opened() as driver:
        await open_progress(driver, catalogue)
        await driver.press("a", "enter")
        driver.see("effort · Effort")
        driver.lacks("Godspeed")
        await driver.press(*"effort"[:1], "enter")
        driver.see("How hard was that for you?")
        await driver.wait(700)
        await driver.press("5", "enter")
        await driver.wait(700)
        await driver.press("enter")
        assert driver.screen_name == "ProgressScreen"
        await driver.settle()
        driver.see("effort")
        await driver.press("enter")
        driver.see("A form is the participant's own")

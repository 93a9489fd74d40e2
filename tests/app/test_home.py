"""The home screen: participants, tasks and past sessions, also of other sites."""

import shutil
from contextlib import closing
from datetime import date, timedelta
from pathlib import Path

import pytest
from textual.widgets import Button

from sar_tui.app.screens.home import HomeScreen
from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from sar_tui.store.database import connect
from sar_tui.store.locks import hold
from sar_tui.widgets.lists import MarkedList, PickList
from tests.app.app_driver import AppDriver, OpenApp, OpenSession, known, open_app, plan, stored
from tests.recorded import told
from tests.sides_task import write_sides
from tests.store.merge.sites import change, merge, site


async def test_a_code_leads_from_a_fresh_start_to_a_session(opened: OpenApp) -> None:
    async with opened() as driver:
        driver.see("+ New participant")
        await driver.press("enter", "enter")
        driver.see("Type a code first.")
        await driver.enter("Peter Maier")
        assert driver.screen_name == "NewParticipantScreen", "a name is refused"
        await driver.press("ctrl+u")
        await driver.enter("p01")
        driver.see("P01 · Keyboard reaction")
        await driver.press("escape", "down", "enter")
        await driver.enter("p01")
        assert driver.screen_name == "NewParticipantScreen", "the code is taken"
        await driver.press("escape", "up", "enter", "enter")
        driver.see("A key appears in the middle of the screen.")
    assert driver.stored("SELECT code FROM participants") == [("P01",)]
    assert driver.stored("SELECT task, theme, mode FROM sessions") == [("keyboard", "calm", "live")]


@pytest.mark.slow
async def test_escape_in_a_list_restores_the_choice(opened: OpenApp, data: Path) -> None:
    known(data, "P02")
    known(data, "P01")
    async with opened() as driver:

        def chosen() -> list[str | None]:
            names = ("participant", "task", "theme")
            return [driver.app.screen.query_one(f"#{name}", MarkedList).chosen for name in names]

        before, text, colors = chosen(), driver.text, driver.app.theme
        await driver.press("down")
        assert driver.text != text
        await driver.press("escape")
        assert driver.text == text
        for way in (("right",), ("right", "right")):
            await driver.press(*way, "down")
            assert chosen() != before
            await driver.press("escape")
            assert chosen() == before
            assert driver.app.focused
            assert driver.app.focused.id == "participant"
        assert driver.app.theme == colors
        await driver.press("right", "down", "enter", "escape")
        assert chosen() != before, "Enter confirms it"


@pytest.mark.slow
async def test_a_part_of_a_code_finds_a_participant(opened: OpenApp, data: Path) -> None:
    for code in ("AB-7", "P17", "P02"):
        known(data, code)
    async with opened() as driver:
        await driver.press("7")
        assert driver.sees("P17 · Keyboard reaction"), "the newest of those with a 7"
        driver.see("find: 7 (Esc)")
        driver.lacks("P02")
        await driver.press("x")
        assert driver.sees("find: 7 (Esc)"), "nobody has 7X"
        await driver.press("backspace", "a")
        driver.see("AB-7 · Keyboard reaction")
        await driver.press("escape")
        driver.see("AB-7")
        assert driver.sees("P02 · Keyboard reaction"), "as before"
        await driver.press("a", "enter", "enter")
        driver.see("Welcome")
    assert stored(data, "SELECT participant FROM seats") == [("AB-7",)]


async def test_the_card_tells_how_a_participant_does(
    opened: OpenApp, open_session: OpenSession, data: Path
) -> None:
    known(data, "P02")
    known(data, "P01")
    for _ in range(2):
        async with open_session() as driver:
            await driver.do_session()
    async with open_session(participant="P02") as driver:
        await driver.answer(await driver.to_first_prompt())
        session = driver.session_id
    (first_session,), (second_session,), _ = stored(data, "SELECT id FROM sessions ORDER BY rowid")
    with closing(connect(data)) as database:
        told(database, "P01", "after", "pain", "6", session=first_session)
        told(database, "P01", "after", "tiredness", "4", session=second_session)
        told(database, "P01", "after", "pain", "3", session=second_session)
    async with opened() as driver:
        driver.see("2 people need a look. 1 person has trained today.")
        driver.see("! Need a look · 2", "P02 Interrupted", "Interrupted today after 0")
        driver.see("P01 Pain 6")
        await driver.press("up")
        driver.see("Pain 6 today, limit 5.", "Programme 2 attempts, 2 prompts each", "goal 1.0 s")
        driver.see("Level at goal, last 2 sessions", ">2 >3", "Reached 2/2 2/2")
        driver.see("Last session all too easy", "Today: 2 of 2 reached, pain 3/10, tired 4/10")
        await driver.press("f6")
        driver.see("Sessions of P01", "Pain Tired", "2 of 2 3 4", "2 of 2 6")
        driver.lacks("P02")
        await driver.press("escape", "down", "f6", "enter")
        assert driver.session_id == session


@pytest.mark.slow
async def test_the_last_task_of_a_participant_is_chosen(opened: OpenApp, data: Path) -> None:
    known(data, "P02")
    known(data, "P01")
    known(data, "P01", task="reaching")
    async with opened() as driver:
        driver.see("P01 · Reaching")
        await driver.press("right")
        driver.app.screen.query_one("#task", PickList).choose("pairs")
        await driver.press("f2", "escape")
        assert driver.screen_name == "HomeScreen"
        driver.see("P01 · Pairs")
        await driver.press("left", "down")
        driver.see("P02 · Keyboard reaction")
        await driver.press("up")
        driver.see("P01 · Reaching")


async def test_a_task_that_does_not_load_or_is_removed_while_it_is_chosen_is_told(
    data: Path, tmp_path: Path
) -> None:
    folder = write_sides(tmp_path / "mine")
    broken = folder.parent / "aaa" / "task.py"
    broken.parent.mkdir()
    broken.write_text("raise RuntimeError('not yet')")
    known(data, "P01")
    async with open_app(data, Catalogue((folder.parent,))) as driver:
        await driver.press("right")
        driver.see("P01 · Keyboard reaction")
        await driver.press("end")
        driver.see("aaa (does not load)")
        await driver.press("escape")
        driver.app.screen.query_one("#task", PickList).choose("sides")
        await driver.settle()
        driver.see("P01 · Sides")
        shutil.rmtree(folder)
        await driver.press("f1", "enter")
        driver.see("There is no task sides")
        await driver.press("f2", "f4")
        assert driver.screen_name == "HomeScreen"


@pytest.mark.slow
async def test_without_a_participant_nothing_starts_and_imprecise_timing_is_told(
    opened: OpenApp, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SSH_CONNECTION", "somewhere")
    monkeypatch.setenv("TMUX", "some")
    async with opened() as driver:
        driver.see("inside ssh and tmux: reaction times are less exact", "Nobody has trained")
        for key in ("f2", "f12"):
            await driver.press(key)
            assert driver.screen_name == "HomeScreen"
            driver.see("Choose or add a participant first.")
            driver.app.clear_notifications()


@pytest.mark.slow
async def test_a_theme_that_is_chosen_is_stored_for_its_participant(
    opened: OpenApp, data: Path
) -> None:
    known(data, "P02")
    known(data, "P01")
    for keys in (("right", "right", "down", "right"), ("right", "right", "right")):
        async with opened() as driver:
            await driver.press(*keys, "enter")
            assert driver.app.theme == "sar-high-contrast"
            await driver.press("escape")
    async with opened() as driver:
        assert driver.app.theme == "sar-high-contrast"
        await driver.press("down")
        assert driver.app.theme == "sar-calm"
    saved = stored(
        data,
        "SELECT version, theme, reason FROM programmes WHERE participant='P01' ORDER BY version",
    )
    reason = "Theme high-contrast was chosen on the first screen."
    assert saved == [(1, "calm", ""), (2, "high-contrast", reason)]
    assert stored(data, "SELECT programme, theme FROM sessions") == [(2, "high-contrast")] * 2


async def test_settings_that_became_invalid_are_told(opened: OpenApp, data: Path) -> None:
    known(data, "P01", attempts=9999, tempo=3, prompts_per_attempt=7)
    async with opened(size=(100, 30)) as driver:
        await driver.fail_to_start("Version 1 of the programme of P01 is not used in full.")
        driver.see("Attempts is a whole number, 1 to 200, not 9999.", "The setting tempo does not")
        driver.see("Press START again to begin")
        assert stored(data, "SELECT id FROM sessions") == []
        driver.app.screen.query_one(
            "#start", Button
        ).press()  # a key has no effect while the button flashes
        await driver.settle()
        driver.see("An attempt asks for 7 keys.")
        await driver.press("enter")
        driver.see("Press Enter to begin attempt 1 of 20.")


@pytest.mark.slow
async def test_an_interrupted_session_is_dismissed_taken_back_and_resumed(
    opened: OpenApp, open_session: OpenSession
) -> None:
    async with open_session(participant="P01") as driver:
        await driver.answer(await driver.to_first_prompt())
        left_at = await driver.to_prompt()
        session = driver.session_id
    async with open_session(participant="P02", attempts=1) as driver:
        await driver.do_session()
    async with opened() as driver:
        await driver.press("down", "f6")
        recent = [row for row in driver.rows if "Keyboard re…" in row]
        assert "P02" in recent[0]
        assert "1 of 1" in recent[0]
        assert "P01" in recent[1]
        assert "interrupted: Enter resumes" in recent[1]

        await driver.press("home")
        assert "Dismiss" not in driver.rows[-1], "a completed session is not dismissed"
        await driver.press("delete", "down", "delete")
        assert driver.stored("SELECT id FROM sessions WHERE status='dismissed'") == [(session,)]
        assert "Del Take back" in driver.rows[-1]
        await driver.press("enter")
        assert driver.screen_name == "PastSessionScreen"
        await driver.press("enter", "delete")
        assert "Del Dismiss" in driver.rows[-1]

        await driver.press("enter")
        assert driver.session_id == session
        driver.see("Welcome back")
        await driver.press("enter")
        prompt = await driver.to_prompt()
        assert (prompt.trial, prompt.text) == (left_at.trial, left_at.text)
        await driver.answer(prompt)
        await driver.finish(await driver.begin())
    assert driver.stored("SELECT status FROM sessions WHERE id=?", session) == [("completed",)]
    found = driver.stored("SELECT attempt, trial FROM trials WHERE session=?", session)
    assert found == [(1, 1), (1, 2), (2, 1), (2, 2)]


@pytest.mark.slow
async def test_a_session_in_another_program_is_shown_so_far_and_not_dismissed(
    opened: OpenApp, open_session: OpenSession, data: Path
) -> None:
    async with open_session(participant="P01") as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        session = driver.session_id
    with closing(connect(data)) as database:
        database.execute("UPDATE sessions SET status = 'running'")
    lock = hold(data, "session", session)
    async with opened() as driver:
        await driver.press("f6", "enter")
        assert driver.screen_name == "PastSessionScreen"
        driver.see("1 attempt so far; goal reached in 1.")
        driver.lacks("Ended early")
        await driver.press("escape", "delete")
        assert stored(data, "SELECT status FROM sessions") == [("running",)]
    lock.release()
    async with opened() as driver:
        await driver.press("f6")
        driver.see("interrupted: Enter resumes", "Press Enter to go on with this session.")
        await driver.press("f4")
        assert driver.screen_name == "ProgressScreen"
        driver.see("· interrupted · 1/2 attempts")


@pytest.mark.slow
async def test_a_removed_tasks_session_is_shown(open_session: OpenSession, data: Path) -> None:
    async with open_session(attempts=1) as driver:
        await driver.do_session()
    nothing = Catalogue()
    nothing._tasks = ()
    async with open_app(data, nothing) as driver:
        await driver.press("f6", "enter")
        assert driver.screen_name == "PastSessionScreen"
        driver.see("You did 1 attempt; goal reached in 1.", "reaction time (s)", "goal 1")
        await driver.press("enter")
        assert driver.screen_name == "HomeScreen"


async def test_tasks_are_listed_by_aim_and_the_open_list_says_what_is_done(
    home: AppDriver, catalogue: Catalogue
) -> None:
    tasks = home.app.screen.query_one("#task", PickList)
    listed = [str(option.prompt) for option in tasks.options]
    assert tasks.chosen == "keyboard"
    assert listed.index("Reaction") < listed.index("Keyboard reaction")
    assert listed.index("Attention") < listed.index("Arrow in the middle")
    aims = {catalogue.task(name).trains for name in catalogue.task_names()}
    headings = [option.disabled for option in tasks.options if option.id is None]
    assert headings == [True] * len(aims)

    home.lacks("Press the key that appears")
    await home.press("right")
    home.see("Press the key that appears, as")
    await home.press("up")
    home.see("Reach out to a marker and back,")
    home.lacks("Press the key that appears")
    await home.press("tab")
    home.see("P01 · Reaching")
    home.lacks("Reach out to a marker")


@pytest.mark.slow
async def test_a_session_of_another_site_is_seen_and_left_as_it_is(
    opened: OpenApp, data: Path, tmp_path: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    bern = tmp_path / "bern"
    async with open_app(bern, catalogue, plan(catalogue, keyboard, "P01")) as driver:
        await driver.answer(await driver.to_first_prompt())
    change(bern, "INSERT INTO site VALUES (1, 'BERN')")
    merge(site(data, "ZURICH"), bern)
    async with opened() as driver:
        assert driver.sees("+ New participant"), "nobody of this site is known yet"
        await driver.press("f6")
        driver.see("P01@BERN", "Press Enter to look at this session.")
        driver.lacks("Enter resumes")
        assert "Dismiss" not in driver.rows[-1]
        await driver.press("delete", "enter")
        driver.see("P01@BERN · Keyboard reaction")
        await driver.press("escape", "escape", "enter")
        await driver.write(*"p01@bern")
        driver.see("P01@BERN is a participant of BERN")
        await driver.press("escape")
    assert stored(data, "SELECT status FROM sessions") == [("interrupted",)]
    assert stored(data, "SELECT code, site FROM participants") == [("P01@BERN", "BERN")]


@pytest.mark.slow
async def test_a_home_left_open_over_night_shows_the_new_day(
    opened: OpenApp, open_session: OpenSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with open_session(attempts=1) as driver:
        await driver.do_session()
    async with opened() as driver:
        driver.see("1 person has trained today.", "1 of 1 goals")
        tomorrow = date.today() + timedelta(days=1)
        monkeypatch.setattr(driver.app, "today", lambda: tomorrow)
        screen = driver.app.screen
        assert isinstance(screen, HomeScreen)
        screen._look_again()
        await driver.settle()
        driver.see("Nobody needs a look today.", "P01 Trained yesterday", f"{tomorrow:%a}")
        driver.lacks("1 of 1 goals")


async def test_who_had_pain_above_the_limit_this_week_is_on_the_first_screen(
    opened: OpenApp, data: Path
) -> None:
    for number in range(30):
        known(data, f"P{number:02}")
    with closing(connect(data)) as database:
        told(database, "P07", "before", "pain", "6")
        told(database, "P13", "before", "pain", "9")
        told(database, "P20", "before", "pain", "5")
    async with opened() as driver:
        driver.see("2 people need a look.")
        driver.see("P13 Pain 9", "P07 Pain 6")
        await driver.press("p", "a")
        driver.see("find: PA (Esc)", "P20 Pain 5/10 this week")
        driver.lacks("P21")
        await driver.press("escape", "down", "enter", "enter")
        driver.see("Welcome")
    assert stored(data, "SELECT participant FROM seats") == [("P07",)]


@pytest.mark.slow
async def test_in_a_small_window_the_sessions_take_the_place_of_the_day_until_escape(
    home: AppDriver,
) -> None:
    home.lacks("Sessions of P01")
    await home.press("f6")
    home.see("Sessions of P01", "No session yet.", "Esc goes back")
    home.lacks("START")
    await home.press("escape")
    home.see("START", "Press Enter twice to start a session of P01.")
    await home.resize(100, 32)
    home.see("START", "Sessions of P01")
    await home.press("f6")
    home.see("START", "Sessions of P01")


async def test_what_enter_does_is_said_where_the_focus_is(home: AppDriver) -> None:
    home.see("Press Enter twice to start a session of P01.")
    home.lacks("▸ START")
    await home.press("enter")
    home.see("Press Enter to start a session of P01.", "▸ START · Enter")
    await home.press("escape", "end")
    home.lacks("▸ START")
    home.see("Press Enter to add a participant.", "F6 shows the sessions of everyone.")
    await home.press("plus")
    assert home.screen_name == "NewParticipantScreen"
    await home.enter("p02")
    home.see("2 people", "P02 · Keyboard reaction", "Press Enter to go on.")

"""The therapist's progress screen: of nobody's sessions, of several, and what its keys do."""

import sqlite3
from contextlib import closing
from datetime import date
from pathlib import Path

import pytest

from sar_tui.app.screens import progress as progress_screen
from sar_tui.app.screens.past_session import PastSessionScreen
from sar_tui.app.screens.progress import ProgressScreen
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import records, sessions
from sar_tui.store.database import connect
from tests.album import Album
from tests.app.app_driver import AppDriver, OpenApp, known
from tests.recorded import score, told


async def open_progress(driver: AppDriver, catalogue: Catalogue) -> None:
    driver.app.push_screen(ProgressScreen("P01", catalogue.task("keyboard")))
    await driver.settle()


def trained(data: Path, catalogue: Catalogue, *thresholds: float) -> None:
    """Store a live session for each goal, with pain of 0, 1, … before it."""
    for number, threshold in enumerate(thresholds):
        settings = {"prompts_per_attempt": 5, "attempts": 12, "threshold": threshold}
        plan = make_plan(catalogue, "keyboard", ["P01"], settings, seed=number, mode="simulated")
        session = simulate(plan, PEOPLE["average"], data, catalogue)
        began = f"2026-03-0{number + 1}T10:00:00+00:00"
        with closing(connect(data)) as database:
            database.execute(
                "UPDATE sessions SET mode='live', started_at=? WHERE id=?", (began, session)
            )
            told(database, "P01", "before", "pain", str(number), session=session)
            database.execute("UPDATE records SET at=? WHERE session=?", (began, session))


async def test_sessions_that_cannot_be_read_and_none_at_all_are_told(
    opened: OpenApp, catalogue: Catalogue, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unreadable(*_: object, **__: object) -> None:
        raise sqlite3.OperationalError("disk I/O error")

    async with opened() as driver:
        with monkeypatch.context() as context:
            context.setattr(progress_screen, "sessions_of", unreadable)
            await open_progress(driver, catalogue)
            for key in ("tab", "enter", "right", "n", "h", "c", "s", "a", "up"):
                await driver.press(key)
            driver.see("The sessions cannot be read:")
            await driver.press("escape")
        await open_progress(driver, catalogue)
        driver.see("No attempt has been finished yet.", "Nothing is recorded yet.")
        for key in "tab shift+tab c n h up end left right s".split():
            await driver.press(key)
        await driver.press("enter")
        driver.see("scores of other tests", "Source: docs/progress.md")
        await driver.press("escape", "escape")
        assert driver.screen_name == "HomeScreen"


async def test_sessions_are_compared(opened: OpenApp, data: Path, catalogue: Catalogue) -> None:
    trained(data, catalogue, 1000, 1000, 900)
    async with opened() as driver:
        driver.app.today = lambda: date(2026, 3, 4)
        (last, *_) = sessions.listing(driver.app.database, data)
        driver.app.push_screen(PastSessionScreen(last))
        await driver.press("f4")
        driver.see("P01 · Keyboard reaction · goal 0.9 s", "1 session · 1 of 2")
        driver.see("The goal is 0.9 s now, and was 1.0 s until 2026-03-02.")
        await driver.press("s")
        driver.see("P01 · Keyboard reaction · goal 1.0 s", "2 sessions · 2 of 2")
        driver.see("These are earlier sessions, with other settings. 2 sessions: too few to say.")
        assert driver.rows[-1].rstrip().endswith("Help")
        assert any(row.split() == ["pain", "0", "1"] for row in driver.rows)
        driver.see("▸ 2 Mar 10:00", "12/12 attempts · 60 repetitions")
        await driver.press("c", "left")
        driver.see("▸ 1 Mar 10:00", "1 Mar and 2 Mar: From")
        driver.see("How much is noise is not yet known")
        assert any(0 < row.find("▲") < row.find("◆") for row in driver.rows)
        await driver.press("escape")
        driver.lacks("1 Mar and 2 Mar")
        await driver.press("up")
        driver.see("▸ 2 Mar 10:00")


async def test_a_figure_is_chosen_and_explained_with_one_key(
    opened: OpenApp, data: Path, catalogue: Catalogue
) -> None:
    trained(data, catalogue, 1000, 1000)
    async with opened() as driver:
        await open_progress(driver, catalogue)
        driver.see("Press Enter to see why.")
        await driver.press("enter")
        driver.see("Verdict", "Steady does not mean that there is no change")
        await driver.press("escape", "tab")
        titles = []
        for _ in range(8):
            (key,) = (row for row in driver.rows if "to see what" in row)
            titles.append(key.split('"')[1])
            await driver.press("enter")
            assert driver.screen_name == "ExplanationScreen"
            assert sum(titles[-1] in row for row in driver.rows) > 0
            await driver.press("escape", "tab")
        assert titles == [
            "Level at goal", "Mean result", "Correct", "Minutes", "Pain", "Sessions", "Days",
            "Records",
        ]  # fmt: skip
        await driver.press("tab", "enter", "right")
        driver.see("95 of 100 ranges hold the true place.", "Source: Fieller 1954")
        await driver.press(*["right"] * 2)
        driver.see("It comes with repeating any test", "Scharfen 2018")


async def test_the_command_palette_has_figures_and_keys_by_name(
    opened: OpenApp, data: Path, catalogue: Catalogue
) -> None:
    trained(data, catalogue, 1000)
    async with opened() as driver:
        await open_progress(driver, catalogue)
        found = list(driver.app.get_system_commands(driver.app.screen))
        names = [each.title for each in found]
        assert {"Level at goal", "Records", "Add", "Note", "Print page", "Help"} <= set(names)
        assert {"Compare", "Other chart"}.isdisjoint(names), "there is one session"
        choose = next(each for each in found if each.title == "Records").callback
        choose()
        await driver.settle()
        driver.see("Nothing is recorded yet.", 'what "Records" means')


@pytest.mark.parametrize("size", [(80, 24), (100, 32), (160, 48)])
async def test_each_list_is_beside_the_picture_or_one_key_away(
    opened: OpenApp, data: Path, catalogue: Catalogue, size: tuple[int, int]
) -> None:
    trained(data, catalogue, 1000, 1000)
    async with opened(size=size) as driver:
        driver.app.today = lambda: date(2026, 3, 4)
        await open_progress(driver, catalogue)
        driver.see("2 sessions: too few to say.", "level at goal")
        for title, shown in (
            ("Records", "Nothing is recorded yet."),
            ("Days", "Mar 2026 ■■"),
            ("Sessions", "▸ 2 Mar"),
        ):
            await driver.press("shift+tab")
            driver.see(f'what "{title}" means', shown)
            is_beside = title != "Days" if size == (100, 32) else size == (160, 48)
            assert driver.sees("level at goal ") == is_beside


async def test_pictures_of_the_screen_at_three_sizes(
    opened: OpenApp, data: Path, catalogue: Catalogue, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLORTERM", "truecolor")
    monkeypatch.delenv("NO_COLOR", raising=False)
    trained(data, catalogue, *[1000] * 6)
    with closing(connect(data)) as database:
        score(database, "P01", "BBT", "2026-03-01", 20)
    for size in ((80, 24), (100, 32), (160, 48)):
        album = Album(Path(__file__).parent / "snapshots", str(size[0]), size)
        async with opened(size=size) as driver:
            driver.app.today = lambda: date(2026, 3, 8)
            await open_progress(driver, catalogue)
            album.take("progress", driver)
        album.check()


async def test_a_note_is_copied_and_a_page_is_written_and_never_over_another(
    opened: OpenApp, data: Path, catalogue: Catalogue, monkeypatch: pytest.MonkeyPatch
) -> None:
    trained(data, catalogue, 1000)
    monkeypatch.setattr("sar_tui.reports.charts.drawn", lambda spec: "<svg ></svg>")
    async with opened() as driver:
        copied: list[str] = []
        monkeypatch.setattr(driver.app, "copy_to_clipboard", copied.append)
        await open_progress(driver, catalogue)
        await driver.press("n", "tab", "tab")
        driver.see("P01, Reacción con el teclado · meta 1,0 s")
        assert copied[0].startswith("P01, Keyboard reaction · goal 1.0 s")
        assert "Ziel 1,0 s" in copied[1]
        assert copied[2].startswith("P01, Reacción con el teclado")
        await driver.press("escape")
        for _ in range(2):
            await driver.press("h")
            await driver.app.workers.wait_for_complete()
            await driver.settle()
    written = sorted(data.glob("*.html"))
    found = [path.name for path in written]
    assert found == ["progress-P01-keyboard-2.html", "progress-P01-keyboard.html"]
    assert "Keyboard reaction" in written[0].read_text(encoding="utf-8")


async def test_scores_are_entered_replaced_and_removed(
    opened: OpenApp, data: Path, catalogue: Catalogue
) -> None:
    known(data)
    with closing(connect(data)) as database:
        score(database, "P01", "BBT", "2026-03-01", 20)
    async with opened() as driver:
        await open_progress(driver, catalogue)
        await driver.press("a", "tab", "tab", *"25", "enter", "enter")
        today = f"{date.today():%-d %b}"
        assert driver.sees(f"▸ {today} BBT 25"), "the new one is chosen"
        await driver.press("a", "tab", "tab", "7")
        driver.see("This replaces 25 of the same day.")
        await driver.press(*"000")
        driver.see("not at 7000.")
        await driver.press("escape", "delete", "enter")
        driver.see("BBT 20")
        driver.lacks("BBT 25")
        assert driver.stored("SELECT version, removed FROM records") == [(1, 0), (1, 0), (2, 1)]


async def test_an_event_gets_its_outcome(opened: OpenApp, data: Path, catalogue: Catalogue) -> None:
    trained(data, catalogue, 1000)
    async with opened() as driver:
        await open_progress(driver, catalogue)
        await driver.press("a", "tab", "tab", *"Cramp", "enter", *"mild", "enter", "enter", "enter")
        driver.see("Cramp, mild", "Outcome not yet recorded.")
        await driver.press("enter", *"Gone", "enter")
        driver.see("mild: Cramp. Outcome: Gone.")
        await driver.press("tab")
        assert any(row.split() == ["look", "at", "!"] for row in driver.rows)
        (event,) = records.listing(driver.app.database, kinds=("adverse-event",))
        assert (event.version, event.content["outcome"]) == (2, "Gone")


async def test_keys_of_records_are_shown_where_a_record_is_chosen(
    opened: OpenApp, data: Path, catalogue: Catalogue
) -> None:
    trained(data, catalogue, 1000, 1000)
    with closing(connect(data)) as database:
        score(database, "P01", "BBT", "2026-03-01", 20)
    async with opened() as driver:
        await open_progress(driver, catalogue)
        assert "Remove" not in driver.rows[-1]
        assert "Note" not in driver.rows[-1], "it is left out where there is no room"
        assert "←→ Session" in driver.rows[-1]
        await driver.press("shift+tab")
        assert "Del Remove" in driver.rows[-1]
        driver.see("correct this record", "F1 Help")

"""The database is removed during a session, or locked at its end: the session is in a rescue file,
and this is said.
"""

import asyncio
import os
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.app.app import SarTui
from sar_tui.app.live import LiveSession
from sar_tui.loop.task import Task
from sar_tui.loop.topics import STORAGE
from sar_tui.model.messages import StorageChanged
from sar_tui.plugins import Catalogue
from sar_tui.store import participants
from sar_tui.store.database import FILE, connect, open_file
from sar_tui.store.rescue import rescue_files
from tests.app.app_driver import AppDriver, OpenApp, OpenSession, plan

posix = pytest.mark.skipif(os.name != "posix", reason="Windows does not remove a file that is open")
WHERE = (
    "data/sar-tui.db was removed while it was in use. The session goes on in "
    "data/sar-tui-rescue-x.db."
)


def delete(data: Path) -> None:
    for path in data.glob(f"{FILE}*"):
        path.unlink()


@pytest.mark.parametrize("keys", [[], ["escape"]], ids=["in a trial", "in a pause"])
async def test_a_session_that_goes_on_elsewhere_pauses_and_says_so(
    driver: AppDriver, keys: list[str]
) -> None:
    prompt = await driver.to_first_prompt()
    await driver.press(*keys)
    driver.session.bus.post(STORAGE, StorageChanged(working=True, reason=WHERE))
    await driver.settle()
    driver.see(f"For the experimenter: {WHERE}")
    await driver.press("enter")
    assert (await driver.to_prompt()).text == prompt.text


async def _settled(app: SarTui, is_so: Any) -> None:
    while not is_so():
        await asyncio.sleep(0)


@pytest.fixture
def begun(
    data: Path, catalogue: Catalogue, keyboard: type[Task], monkeypatch: pytest.MonkeyPatch
) -> SarTui:
    """An app that begins a session, in which keys count at once."""
    monkeypatch.setattr("sar_tui.rules.keys.UNREAD", 0)
    return SarTui(data, catalogue, plan(catalogue, keyboard))


async def lose_the_database(app: SarTui, data: Path, *, is_mistake: bool = False) -> list[str]:
    """Delete the database in a session, leave that, and return the lines that are left."""
    async with app.run_test() as pilot:
        await pilot.press("enter")
        delete(data)
        await _settled(app, lambda: rescue_files(data))
        await pilot.press("ctrl+c")
        assert app.live
        app.live.is_mistake = is_mistake
    app.close_session()
    return list(app.leaving.lines(1))


@posix
async def test_a_database_that_is_removed_in_a_session_costs_nothing(
    data: Path, begun: SarTui
) -> None:
    first, second = await lose_the_database(begun, data)
    (path,) = rescue_files(data)
    with closing(open_file(path)) as rescue:
        assert rescue.execute("SELECT status FROM sessions").fetchall() == [("interrupted",)]
        (keys,) = rescue.execute("SELECT count(*) FROM events WHERE topic='input/key'").fetchone()
    assert keys == 1
    assert first.startswith(f"{data / FILE} was removed while it was in use. The session goes on")
    assert f"in {path}. Bring it back into the database: sar-tui rescue --data" in first
    assert second.startswith("The session is kept. Resume it: sar-tui resume")


@posix
async def test_a_mistake_that_could_not_be_noted_is_told(data: Path, begun: SarTui) -> None:
    said = "\n".join(await lose_the_database(begun, data, is_mistake=True))
    assert "The session does not count" not in said
    assert "but it could not be marked as such, and counts." in said


async def test_a_session_that_is_left_while_the_database_is_locked_is_in_a_rescue_file(
    data: Path, begun: SarTui, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sar_tui.runs.run._LAST_WAIT_MS", 1)
    async with begun.run_test() as pilot:
        await pilot.pause()
        with closing(sqlite3.connect(data / FILE, isolation_level=None)) as other:
            other.execute("BEGIN IMMEDIATE")
            await pilot.press("enter", "ctrl+c")
            begun.close_session()
    (path,) = rescue_files(data)
    with closing(open_file(path)) as rescue:
        (keys,) = rescue.execute("SELECT count(*) FROM events WHERE topic='input/key'").fetchone()
    assert keys == 1
    assert begun.live
    assert begun.live.unsaved == 0
    assert "Another program keeps sar-tui.db locked." in begun.live.rescued


async def test_the_screen_stays_until_the_session_is_written(
    open_session: OpenSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    is_written = asyncio.Event()
    loop = asyncio.get_running_loop()

    def wait(_: LiveSession, seconds: float) -> bool:
        if seconds < 1 or is_written.is_set():
            return is_written.is_set()
        asyncio.run_coroutine_threadsafe(is_written.wait(), loop).result()
        return True

    monkeypatch.setattr(LiveSession, "is_written", wait)
    async with open_session() as driver:
        await driver.press("ctrl+c")
        driver.see("One moment… Your results are being saved.")
        await driver.press("ctrl+c", "enter")
        assert driver.app.is_running
        is_written.set()
        await _settled(driver.app, lambda: not driver.app.is_running)


@posix
async def test_home_opens_a_removed_database_anew(home: AppDriver, data: Path) -> None:
    await home.press("f2")
    delete(data)
    await home.press("escape")
    home.see("was removed while it was in use.")
    participants.add(home.app.database, "P02")
    with closing(connect(data)) as database:
        assert participants.codes(database) == ["P02"]


async def test_the_home_screen_says_that_a_rescue_file_waits(opened: OpenApp, data: Path) -> None:
    open_file(data / "sar-tui-rescue-0123456789.db").close()
    async with opened(size=(120, 40)) as driver:
        driver.see("`sar-tui rescue` brings it back.")

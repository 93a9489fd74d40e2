"""A live session runs in two named Textual workers, which end with the app."""

from pathlib import Path

import pytest

from sar_tui.app.app import SarTui
from sar_tui.app.screen_keys import ScreenKeys
from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from tests.app.app_driver import known, plan, stored


async def test_workers_end_with_it(data: Path, catalogue: Catalogue, keyboard: type[Task]) -> None:
    app = SarTui(data, catalogue, plan(catalogue, keyboard))
    async with app.run_test() as pilot:
        await pilot.pause()
        found = {worker.name for worker in app.workers if worker.is_running}
        assert found == {"session", "storage"}
        await pilot.press("ctrl+q", "down", "enter")
    app.close_session()
    assert not [worker for worker in app.workers if worker.is_running]
    assert app.live
    assert app.live.unsaved == 0
    assert stored(data, "SELECT status FROM sessions") == [("interrupted",)]


@pytest.mark.slow
async def test_workers_end_with_the_session_when_the_app_continues(
    data: Path, catalogue: Catalogue, monkeypatch: pytest.MonkeyPatch
) -> None:
    # in real time, nobody is that fast
    monkeypatch.setattr(ScreenKeys, "pass_on", lambda *_, **__: True)
    known(data, "P01")
    app = SarTui(data, catalogue)
    async with app.run_test() as pilot:
        assert not list(app.workers)
        await pilot.press("right", "right", "right", "enter")
        await pilot.pause()
        found = {worker.name for worker in app.workers if worker.is_running}
        assert found == {"session", "storage"}
        await pilot.press("escape", "up", "up", "enter", "down", "enter", "enter")
        await app.workers.wait_for_complete(list(app.workers))
        await pilot.pause()
        assert not [worker for worker in app.workers if worker.is_running]
        assert type(app.screen).__name__ == "HomeScreen"
    assert stored(data, "SELECT status FROM sessions") == [("aborted",)]

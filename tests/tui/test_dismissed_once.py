from typing import Any

from textual.app import App
from textual.screen import ModalScreen

from sar_tui.tui.dismissed_once import DismissedOnce


class Below(DismissedOnce[str]):
    pass


class Dialog(DismissedOnce[str], ModalScreen[str]):
    pass


async def test_a_screen_that_a_dialog_covers_does_not_close_the_dialog() -> None:
    app: App[Any] = App()
    results: list[str | None] = []
    async with app.run_test() as pilot:
        below, dialog = Below(), Dialog()
        await app.push_screen(below, results.append)
        await app.push_screen(dialog, results.append)
        below.dismiss("too early")
        await pilot.pause()
        assert (app.screen, results) == (dialog, [])
        dialog.dismiss("dialog")
        dialog.dismiss("again")
        await pilot.pause()
        below.dismiss("below")
        await pilot.pause()
        assert results == ["dialog", "below"]

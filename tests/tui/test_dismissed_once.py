import asyncio
from typing import Any

from textual.app import App, ComposeResult
from textual.screen import ModalScreen
from textual.widget import Widget
from textual.widgets import Static

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


class Slow(DismissedOnce[str]):
    """A screen that waits before its parts are made."""

    def __init__(self) -> None:
        super().__init__()
        self.is_half_open, self.may_go_on = asyncio.Event(), asyncio.Event()

    def compose(self) -> ComposeResult:
        yield Static(id="part")

    async def mount_composed_widgets(self, widgets: list[Widget]) -> None:
        self.is_half_open.set()
        await self.may_go_on.wait()
        await super().mount_composed_widgets(widgets)

    def on_mount(self) -> None:
        self.query_one("#part", Static).update("there")


async def test_a_screen_that_is_closed_while_it_opens_has_its_parts_first() -> None:
    app: App[Any] = App()
    results: list[str | None] = []
    async with app.run_test() as pilot:
        app.push_screen(screen := Slow(), results.append)
        await screen.is_half_open.wait()
        screen.dismiss("closed")
        for _ in range(50):
            await asyncio.sleep(0)
        screen.may_go_on.set()
        await pilot.pause()
        assert results == ["closed"]
        assert app.screen is not screen

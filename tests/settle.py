"""Waits until a Textual app under test has nothing left to do."""

import asyncio
from typing import Any

from textual.app import App


async def settle(app: App[Any]) -> None:
    """Run the event loop until the app has handled every message and drawn every change.

    Textual's own `Pilot.pause` sends a message to each widget and waits for all of them, which
    takes most of the time of a test with a large form. This function asks the event loop whether
    any of its tasks is ready.
    """
    ready = asyncio.get_running_loop()._ready  # type: ignore[attr-defined]
    rounds = 0
    while app.is_running and rounds < 2:
        while ready:
            await asyncio.sleep(0)
        rounds += 1
        app.screen._on_timer_update()
        if ready or app.screen._callbacks:
            rounds = 0
        await asyncio.sleep(0)
